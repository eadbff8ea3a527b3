#pragma once
// Work for a device in pieces that are submitted one after another, two at a time, so that cancelling is answered soon.

#include <functional>
#include <vector>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/core/cancel.h"

namespace photond {

class PieceQueue {
public:
    using Record = std::function<void(gpu::CommandList& commands)>;

    /// A part of a pass: about as long as that many paths take.
    struct Step {
        uint64_t paths;
        Record record;
    };
    /// Steps in their order, as many to a piece as a submit of the device may hold.
    static std::vector<Record> pieces_of(gpu::Device& device, std::vector<Step> steps);

    explicit PieceQueue(gpu::Device& device) : lists_{gpu::CommandList(device), gpu::CommandList(device)} {}

    /// Begins these, after what was begun before is done: two of them are submitted.
    void start(std::vector<Record> pieces);
    /// Waits for all of them. The device's times are added to the stages of their scopes. False: cancelled, some were
    /// never begun.
    bool finish(Stats& stats, const CancelToken& cancel);
    bool run(std::vector<Record> pieces, Stats& stats, const CancelToken& cancel) {
        start(std::move(pieces));
        return finish(stats, cancel);
    }

private:
    static constexpr size_t kWaiting = 2;  // pieces submitted and not done

    void submit_next();

    std::vector<Record> pieces_;
    size_t submitted_ = 0, done_ = 0;
    gpu::CommandList lists_[kWaiting];
};

}  // namespace photond

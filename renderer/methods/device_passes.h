#pragma once
// Passes on a device: each is cut into pieces that are submitted one after another, so that cancelling is answered
// soon, and the next pass may begin while the last one is folded into the film.

#include <functional>
#include <memory>
#include <optional>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/core/cancel.h"

namespace photond {

/// Two slots take turns: what a pass leaves on the device stays in its slot until the pass after the next begins.
class DevicePasses {
public:
    static constexpr uint32_t kSlots = 2;
    /// Records a piece of a pass; all of the slot's earlier work is done by then.
    using Record = std::function<void(uint32_t pass, uint32_t slot, uint32_t piece, gpu::CommandList& commands)>;

    DevicePasses(gpu::Device& device, uint32_t pieces, Record record);

    /// Runs the pass, or the rest of it if it was expected; the slot it is in, or none: cancelled. The device's times
    /// are added to the stages of their scopes.
    std::optional<uint32_t> run(uint32_t pass, Stats& stats, const CancelToken& cancel);
    /// Begins the pass: as many pieces as are let wait at once.
    void expect(uint32_t pass);
    /// Waits for what has been begun.
    void settle();

private:
    static constexpr uint32_t kWaiting = 2;  // pieces submitted and not done

    struct Slot {
        std::optional<uint32_t> pass;
        uint32_t submitted = 0;
        std::vector<std::unique_ptr<gpu::CommandList>> pieces;
    };
    Slot& begin(uint32_t pass);
    void submit_next(Slot& slot);

    gpu::Device& device_;
    const uint32_t pieces_;
    const Record record_;
    uint32_t last_slot_ = 1;
    Slot slots_[kSlots];
};

}  // namespace photond

#pragma once
// Passes on a device, cut into pieces: the next may begin while the last one is folded into the film.

#include <optional>

#include "renderer/frame/piece_queue.h"

namespace photond {

/// Two slots take turns: what a pass leaves on the device stays in its slot until the pass after the next begins.
class DevicePasses {
public:
    static constexpr uint32_t kSlots = 2;
    /// Records a piece of a pass; all of the slot's earlier work is done by then.
    using Record = std::function<void(uint32_t pass, uint32_t slot, uint32_t piece, gpu::CommandList& commands)>;

    DevicePasses(gpu::Device& device, uint32_t pieces, Record record)
        : device_(device), pieces_(pieces), record_(std::move(record)), queue_(device) {}

    /// Runs the pass, or the rest of it if it was expected; the slot it is in, or none: cancelled. The device's times
    /// are added to the stages of their scopes.
    std::optional<uint32_t> run(uint32_t pass, Stats& stats, const CancelToken& cancel);
    /// Begins the pass: as many pieces as are let wait at once.
    void expect(uint32_t pass);
    /// Waits for what has been begun.
    void settle() { device_.wait_idle(); }

private:
    gpu::Device& device_;
    const uint32_t pieces_;
    const Record record_;
    std::optional<uint32_t> expected_;
    uint32_t slot_ = 1;  // of the pass begun last
    PieceQueue queue_;
};

}  // namespace photond

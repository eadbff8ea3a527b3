#include "renderer/methods/device_passes.h"

namespace photond {

DevicePasses::DevicePasses(gpu::Device& device, uint32_t pieces, Record record)
    : device_(device), pieces_(pieces), record_(std::move(record)) {
    for (Slot& slot : slots_)
        for (uint32_t i = 0; i < pieces; ++i) slot.pieces.push_back(std::make_unique<gpu::CommandList>(device));
}

/// The slot that holds the pass, or the one whose turn it is.
DevicePasses::Slot& DevicePasses::begin(uint32_t pass) {
    for (Slot& slot : slots_)
        if (slot.pass == pass) return slot;
    const uint32_t index = 1 - last_slot_;
    last_slot_ = index;
    Slot& slot = slots_[index];
    for (const auto& piece : slot.pieces) piece->wait();  // of a pass that was expected and never came
    slot.pass = pass;
    slot.submitted = 0;
    return slot;
}

void DevicePasses::submit_next(Slot& slot) {
    gpu::CommandList& commands = *slot.pieces[slot.submitted];
    commands.reset();
    record_(*slot.pass, static_cast<uint32_t>(&slot - slots_), slot.submitted, commands);
    commands.submit();
    ++slot.submitted;
}

std::optional<uint32_t> DevicePasses::run(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    Slot& slot = begin(pass);
    for (uint32_t done = 0; done < pieces_; ++done) {
        while (slot.submitted < pieces_ && slot.submitted < done + kWaiting && !cancel.cancelled()) submit_next(slot);
        if (done >= slot.submitted) break;
        slot.pieces[done]->wait();
    }
    const bool whole = slot.submitted == pieces_;
    slot.pass.reset();  // another run of the same pass is made anew
    if (!whole || cancel.cancelled()) return std::nullopt;
    for (const auto& piece : slot.pieces) piece->add_times(stats);
    return static_cast<uint32_t>(&slot - slots_);
}

void DevicePasses::expect(uint32_t pass) {
    Slot& slot = begin(pass);
    while (slot.submitted < pieces_ && slot.submitted < kWaiting) submit_next(slot);
}

void DevicePasses::settle() { device_.wait_idle(); }

}  // namespace photond

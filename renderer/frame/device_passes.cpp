#include "renderer/frame/device_passes.h"

namespace photond {

void DevicePasses::expect(uint32_t pass) {
    if (expected_ == pass) return;
    slot_ = 1 - slot_;
    std::vector<PieceQueue::Record> pieces;
    for (uint32_t piece = 0; piece < pieces_; ++piece)
        pieces.push_back(
            [this, pass, slot = slot_, piece](gpu::CommandList& commands) { record_(pass, slot, piece, commands); });
    queue_.start(std::move(pieces));
    expected_ = pass;
}

std::optional<uint32_t> DevicePasses::run(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    expect(pass);
    expected_.reset();  // another run of the same pass is made anew
    if (!queue_.finish(stats, cancel) || cancel.cancelled()) return std::nullopt;
    return slot_;
}

}  // namespace photond

#include "renderer/frame/piece_queue.h"

#include <memory>

namespace photond {

std::vector<PieceQueue::Record> PieceQueue::pieces_of(gpu::Device& device, std::vector<Step> steps) {
    const auto all = std::make_shared<const std::vector<Step>>(std::move(steps));
    const uint64_t most = device.paths_per_submit();
    std::vector<Record> pieces;
    for (size_t first = 0, end = 0; first < all->size(); first = end) {
        uint64_t paths = (*all)[first].paths;
        for (end = first + 1; end < all->size() && paths + (*all)[end].paths <= most; ++end) paths += (*all)[end].paths;
        pieces.push_back([all, first, end](gpu::CommandList& commands) {
            for (size_t i = first; i < end; ++i) (*all)[i].record(commands);
        });
    }
    return pieces;
}

void PieceQueue::submit_next() {
    gpu::CommandList& commands = lists_[submitted_ % kWaiting];
    commands.reset();
    pieces_[submitted_](commands);
    commands.submit();
    ++submitted_;
}

void PieceQueue::start(std::vector<Record> pieces) {
    for (gpu::CommandList& commands : lists_) commands.wait();
    pieces_ = std::move(pieces);
    submitted_ = done_ = 0;
    while (submitted_ < pieces_.size() && submitted_ < kWaiting) submit_next();
}

bool PieceQueue::finish(Stats& stats, const CancelToken& cancel) {
    for (; done_ < pieces_.size(); ++done_) {
        while (submitted_ < pieces_.size() && submitted_ < done_ + kWaiting && !cancel.cancelled()) submit_next();
        if (done_ >= submitted_) return false;
        gpu::CommandList& commands = lists_[done_ % kWaiting];
        commands.wait();
        commands.add_times(stats);
    }
    return true;
}

}  // namespace photond

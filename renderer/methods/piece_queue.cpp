#include "renderer/methods/piece_queue.h"

namespace photond {

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

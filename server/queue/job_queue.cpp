#include "server/queue/job_queue.h"

namespace photond {

void JobQueue::push(int64_t seq, int priority, const std::string& device) {
    const Place place{priority, seq};
    if (places_.emplace(seq, std::pair(device, place)).second) queues_[device].insert(place);
}

bool JobQueue::remove(int64_t seq) {
    const auto found = places_.find(seq);
    if (found == places_.end()) return false;
    queues_[found->second.first].erase(found->second.second);
    places_.erase(found);
    return true;
}

std::optional<int64_t> JobQueue::front(const std::string& device) const {
    const auto found = queues_.find(device);
    if (found == queues_.end() || found->second.empty()) return std::nullopt;
    return found->second.begin()->seq;
}

}  // namespace photond

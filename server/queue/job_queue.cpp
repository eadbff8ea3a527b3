#include "server/queue/job_queue.h"

namespace photond {

void JobQueue::push(int64_t seq, int priority, const std::string& device) {
    if (held_.count(seq)) return;
    const Place place{priority, seq};
    if (places_.emplace(seq, std::pair(device, place)).second) queues_[device].insert(place);
}

void JobQueue::hold(int64_t seq, int priority, const std::string& device, int64_t until) {
    if (places_.count(seq)) return;
    if (held_.emplace(seq, Held{priority, device, until}).second) held_until_[until].insert(seq);
}

std::vector<int64_t> JobQueue::release(int64_t until) {
    const auto found = held_until_.find(until);
    if (found == held_until_.end()) return {};
    std::vector<int64_t> released(found->second.begin(), found->second.end());
    for (const int64_t seq : released) {
        const Held held = held_.at(seq);
        remove(seq);
        push(seq, held.priority, held.device);
    }
    return released;
}

bool JobQueue::remove(int64_t seq) {
    if (const auto held = held_.find(seq); held != held_.end()) {
        const auto others = held_until_.find(held->second.until);
        others->second.erase(seq);
        if (others->second.empty()) held_until_.erase(others);
        held_.erase(held);
        return true;
    }
    const auto found = places_.find(seq);
    if (found == places_.end()) return false;
    queues_[found->second.first].erase(found->second.second);
    places_.erase(found);
    return true;
}

std::optional<int64_t> JobQueue::waits_for(int64_t seq) const {
    const auto held = held_.find(seq);
    if (held == held_.end()) return std::nullopt;
    return held->second.until;
}

std::optional<int64_t> JobQueue::front(const std::string& device) const {
    const auto found = queues_.find(device);
    if (found == queues_.end() || found->second.empty()) return std::nullopt;
    return found->second.begin()->seq;
}

}  // namespace photond

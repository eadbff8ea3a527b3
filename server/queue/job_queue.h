#pragma once
// The order in which waiting jobs run: for each device by priority, then first come, first served.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>

namespace photond {

/// The store's queued jobs, in memory. Not thread-safe: the service's lock serialises.
class JobQueue {
public:
    /// Nothing happens when it is in the queue already.
    void push(int64_t seq, int priority, const std::string& device);
    /// False when it was not there.
    bool remove(int64_t seq);
    /// The next one for a device, which stays in the queue.
    std::optional<int64_t> front(const std::string& device) const;
    size_t size() const { return places_.size(); }

private:
    struct Place {
        int priority;
        int64_t seq;
        bool operator<(const Place& other) const {
            return priority != other.priority ? priority > other.priority : seq < other.seq;
        }
    };
    std::map<std::string, std::set<Place>> queues_;  // by device
    std::unordered_map<int64_t, std::pair<std::string, Place>> places_;
};

}  // namespace photond

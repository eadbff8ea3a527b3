#pragma once
// The order in which waiting jobs run: for each device by priority, then first come, first served; and beside it those
// that may not run before another job is over.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

namespace photond {

/// The store's queued jobs, in memory. Not thread-safe: the service's lock serialises.
class JobQueue {
public:
    /// Nothing happens when it is in the queue, or held, already.
    void push(int64_t seq, int priority, const std::string& device);
    /// Kept out of the queue until release(until). Nothing happens when it is in the queue, or held, already.
    void hold(int64_t seq, int priority, const std::string& device, int64_t until);
    /// Queues those that were held until then; which they are, in the order of their numbers.
    std::vector<int64_t> release(int64_t until);
    /// From the queue, or from among those held. False when it was not there.
    bool remove(int64_t seq);
    /// The job that one is held for.
    std::optional<int64_t> waits_for(int64_t seq) const;
    /// The next one for a device, which stays in the queue.
    std::optional<int64_t> front(const std::string& device) const;
    /// Those held included.
    size_t size() const { return places_.size() + held_.size(); }

private:
    struct Place {
        int priority;
        int64_t seq;
        bool operator<(const Place& other) const {
            return priority != other.priority ? priority > other.priority : seq < other.seq;
        }
    };
    struct Held {
        int priority;
        std::string device;
        int64_t until;
    };
    std::map<std::string, std::set<Place>> queues_;  // by device
    std::unordered_map<int64_t, std::pair<std::string, Place>> places_;
    std::unordered_map<int64_t, Held> held_;
    std::map<int64_t, std::set<int64_t>> held_until_;  // by what they wait for
};

}  // namespace photond

#include "server/events.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>

#include "protocol/error.h"

namespace photond {

EventHub::EventHub() : wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (wake_fd_ < 0) throw Error(ErrorCode::Internal, std::string("eventfd: ") + std::strerror(errno));
}

EventHub::~EventHub() { close(wake_fd_); }

void EventHub::open(uint64_t next_id, History history) {
    const std::lock_guard lock(mutex_);
    next_id_ = memory_from_ = next_id;
    recent_.clear();
    history_ = std::move(history);
}

uint64_t EventHub::next_id() const {
    const std::lock_guard lock(mutex_);
    return next_id_;
}

uint64_t EventHub::last_id() const { return next_id() - 1; }

void EventHub::publish(Event event) {
    {
        const std::lock_guard lock(mutex_);
        assert(event.id == next_id_ && "ids are given out in order, one at a time");
        ++next_id_;
        recent_.push_back(std::move(event));
        if (recent_.size() > kKept) {
            memory_from_ = recent_.front().id + 1;
            recent_.pop_front();
        }
    }
    const uint64_t one = 1;
    // A full counter means that the reader has been woken already.
    [[maybe_unused]] const ssize_t written = write(wake_fd_, &one, sizeof one);
}

std::vector<Event> EventHub::after(uint64_t id, const std::string& job, size_t limit) const {
    std::vector<Event> events;
    History history;
    uint64_t memory_from = 0;
    {
        const std::lock_guard lock(mutex_);
        memory_from = memory_from_;
        if (id + 1 < memory_from_) history = history_;
    }
    // Without the hub's lock: whoever publishes holds the service's lock and then asks for the hub's.
    if (history) {
        events = history(id, memory_from, job, limit);
        if (events.size() >= limit) return events;
        id = memory_from - 1;
    }
    const std::lock_guard lock(mutex_);
    auto from = std::upper_bound(recent_.begin(), recent_.end(), id,
                                 [](uint64_t value, const Event& event) { return value < event.id; });
    for (; from != recent_.end() && events.size() < limit; ++from)
        if (job.empty() || from->job == job) events.push_back(*from);
    return events;
}

}  // namespace photond

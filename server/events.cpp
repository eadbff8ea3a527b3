#include "server/events.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>

#include "protocol/error.h"

namespace photond {

EventHub::EventHub() = default;

EventHub::~EventHub() {
    for (const int file : wake_fds_) close(file);
}

int EventHub::make_wake_fd() {
    const int file = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (file < 0) throw Error(ErrorCode::Internal, std::string("eventfd: ") + std::strerror(errno));
    const std::lock_guard lock(mutex_);
    wake_fds_.push_back(file);
    return file;
}

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
    std::vector<int> wakes;
    {
        const std::lock_guard lock(mutex_);
        wakes = wake_fds_;
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
    for (const int file : wakes) [[maybe_unused]] const ssize_t written = write(file, &one, sizeof one);
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

#pragma once
// Events of jobs (protocol.md, "Events"): one rising numbering for the whole daemon, going on across restarts.

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace photond {

struct Event {
    uint64_t id = 0;
    std::string type;  // "progress", "curve", "state"
    std::string job;   // id of the job it is about
    std::string data;  // one line of JSON: the changed fields of the job object and its "id"
};

/// Hands events from the service to whoever streams them. `state` and `curve` events are kept in the store; `progress`
/// events only in memory, for they are superseded by the next one. Thread-safe.
class EventHub {
public:
    EventHub();
    ~EventHub();
    EventHub(const EventHub&) = delete;
    EventHub& operator=(const EventHub&) = delete;

    /// Events with a greater id, oldest first, at most `limit`; `job` empty: all jobs. Stored events come first where
    /// the memory does not reach back far enough.
    std::vector<Event> after(uint64_t id, const std::string& job = "", size_t limit = 1000) const;
    /// The greatest id given out.
    uint64_t last_id() const;

    /// An eventfd (non-blocking, close-on-exec) that becomes readable with every new event, for one thread: poll it,
    /// read it, then ask after(). Another one each time; owned by the hub, and asked for before events are published.
    int make_wake_fd();

    // --- the service's side
    // -------------------------------------------------------------------------------------------
    using History =
        std::function<std::vector<Event>(uint64_t after_id, uint64_t before_id, const std::string& job, size_t limit)>;
    /// Where events that memory no longer holds are read, and the first id to give out.
    void open(uint64_t next_id, History history);
    /// The id the next event will have. The caller serialises next_id() and publish() (the service's lock does).
    uint64_t next_id() const;
    void publish(Event event);

private:
    static constexpr size_t kKept = 4096;  // events in memory

    mutable std::mutex mutex_;
    std::deque<Event> recent_;
    uint64_t next_id_ = 1;
    uint64_t memory_from_ = 1;  // every event with this id or a greater one is in recent_
    History history_;
    std::vector<int> wake_fds_;
};

}  // namespace photond

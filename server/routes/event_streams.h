#pragma once
// All event streams (text/event-stream), on one thread, whatever their number.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "server/events.h"
#include "server/routes/connection.h"

namespace photond::http {

/// One event as it stands on the wire.
std::string event_text(const Event& event);
/// The daemon's status as an event. It has no id: it is of the moment, and nothing to resume by.
std::string status_event_text(const nlohmann::json& status);

class EventStreams {
public:
    /// `clients_changed(+1 or -1)` for the metrics. `status` is asked once a second while somebody listens to the
    /// whole daemon.
    EventStreams(EventHub& events, std::function<void(int)> clients_changed, std::function<nlohmann::json()> status);
    ~EventStreams();
    EventStreams(const EventStreams&) = delete;
    EventStreams& operator=(const EventStreams&) = delete;

    void start();
    /// From any thread: a connection whose reply is an EventSubscription and whose wire is still to be sent.
    void adopt(std::unique_ptr<Connection> connection);
    /// Closes all streams and ends the thread. Clients come back with Last-Event-ID.
    void stop();

private:
    struct Stream;

    void run();
    void take_inbox();
    void spread_new_events();
    void catch_up(Stream& stream);
    void flush(Stream& stream);
    void tick();
    void spread_status();
    void drop(int socket);

    EventHub& events_;
    const std::function<void(int)> clients_changed_;
    const std::function<nlohmann::json()> status_;
    FileDescriptor epoll_, wake_;
    const int news_;  // EventHub::make_wake_fd()
    std::unordered_map<int, std::unique_ptr<Stream>> streams_;
    uint64_t spread_ = 0;  // every event up to this id has been given to the streams that were up to date
    std::mutex mutex_;
    std::vector<std::unique_ptr<Connection>> inbox_;
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

}  // namespace photond::http

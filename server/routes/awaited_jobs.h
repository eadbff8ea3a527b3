#pragma once
// Requests that wait for a job to be over, on one thread, whatever their number.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <vector>

#include "server/events.h"
#include "server/routes/answerer.h"
#include "server/routes/connection.h"

namespace photond::http {

struct AwaitedJobsCallbacks {
    /// Gets a connection whose request begins anew. False, and the connection left where it is, when there is no room
    /// for it.
    std::function<bool(std::unique_ptr<Connection>&)> again;
    /// Gets one back that was answered instead.
    std::function<void(std::unique_ptr<Connection>)> answered;
    /// Is told that one was dropped because its client has gone.
    std::function<void()> gone;
};

class AwaitedJobs {
public:
    AwaitedJobs(EventHub& events, AwaitedJobsCallbacks callbacks);
    ~AwaitedJobs();
    AwaitedJobs(const AwaitedJobs&) = delete;
    AwaitedJobs& operator=(const AwaitedJobs&) = delete;

    void start();
    /// From any thread: a connection whose exchange awaits a job.
    void hold(std::unique_ptr<Connection> connection);
    /// From now on nobody waits any more: the time of all is over at once.
    void let_go();
    /// Closes what is still held and ends the thread.
    void stop();

private:
    void run();
    void take_inbox();
    void see_new_events();
    void begin_anew(int socket);
    void client_left(int socket);
    int milliseconds_to_next_end() const;
    void wake();

    EventHub& events_;
    const AwaitedJobsCallbacks callbacks_;
    FileDescriptor epoll_, wake_;
    const int news_;     // EventHub::make_wake_fd()
    uint64_t seen_ = 0;  // every event up to this id has been told to those who wait
    std::unordered_map<int, std::unique_ptr<Connection>> held_;  // by their sockets
    Answerer refuses_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Connection>> inbox_;
    std::atomic<bool> letting_go_{false}, stopping_{false};
    std::thread thread_;
};

}  // namespace photond::http

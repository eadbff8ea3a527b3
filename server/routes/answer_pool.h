#pragma once
// A lane: a bounded set of threads with a bounded queue in front, each thread with an Answerer of its own. A request
// whose client has gone is not worked on, nor one that waited too long: its client is told to come back. One that turns
// out to need a helper leaves a lane whose threads may not wait for one.

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "server/routes/answerer.h"
#include "server/routes/fair_queue.h"

namespace photond::http {

struct Connection;

struct LaneSettings {
    size_t threads = 1;
    size_t max_waiting = 0;
    double most_wait_seconds = 0;  // in the queue
    double most_work_seconds = 0;  // on what is made in pieces (Call::before_piece)
    bool waits_for_helper = false;
};

struct LaneCallbacks {
    /// Gets a connection back, answered.
    std::function<void(std::unique_ptr<Connection>)> done;
    /// Is told that one was dropped because its client has gone.
    std::function<void()> gone;
    /// Gets a connection that needs a helper, unanswered. False, and the connection left where it is, when there is no
    /// room for it. Asked where the lane does not wait for a helper.
    std::function<bool(std::unique_ptr<Connection>&)> needs_helper;
    /// Gets a connection whose request waits for a job, unanswered.
    std::function<void(std::unique_ptr<Connection>)> awaits_job;
};

class AnswerPool {
public:
    AnswerPool(LaneSettings settings, LaneCallbacks callbacks);
    ~AnswerPool();
    AnswerPool(const AnswerPool&) = delete;
    AnswerPool& operator=(const AnswerPool&) = delete;

    /// False, and the connection left where it is, when too many wait already, of its client or in all.
    bool submit(std::unique_ptr<Connection>& connection);
    /// Finishes what is being answered, drops what waits.
    void stop();

private:
    void run();

    struct Waiting {
        std::unique_ptr<Connection> connection;
        Clock::time_point since;
    };

    const LaneSettings settings_;
    const LaneCallbacks callbacks_;
    std::mutex mutex_;
    std::condition_variable wake_;
    FairQueue<Waiting> waiting_;
    bool stopping_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace photond::http

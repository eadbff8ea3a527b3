#pragma once
// A bounded set of threads with a bounded queue in front, each with an Answerer of its own.

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/routes/answerer.h"

namespace photond::http {

struct Connection;

class AnswerPool {
public:
    /// `done` gets every connection back, answered.
    using Done = std::function<void(std::unique_ptr<Connection>)>;
    AnswerPool(size_t threads, size_t max_waiting, Done done);
    ~AnswerPool();
    AnswerPool(const AnswerPool&) = delete;
    AnswerPool& operator=(const AnswerPool&) = delete;

    /// False, and the connection left where it is, when too many wait already.
    bool submit(std::unique_ptr<Connection>& connection);
    /// Finishes what is being answered, drops what waits.
    void stop();

private:
    void run();

    const size_t max_waiting_;
    const Done done_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::unique_ptr<Connection>> waiting_;
    bool stopping_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace photond::http

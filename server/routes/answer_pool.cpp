#include "server/routes/answer_pool.h"

#include "server/routes/connection.h"

namespace photond::http {

AnswerPool::AnswerPool(size_t threads, size_t max_waiting, Done done)
    : max_waiting_(max_waiting), done_(std::move(done)) {
    for (size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

AnswerPool::~AnswerPool() { stop(); }

bool AnswerPool::submit(std::unique_ptr<Connection>& connection) {
    {
        const std::lock_guard lock(mutex_);
        if (stopping_ || waiting_.size() >= max_waiting_) return false;
        waiting_.push_back(std::move(connection));
    }
    wake_.notify_one();
    return true;
}

void AnswerPool::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        waiting_.clear();
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
}

void AnswerPool::run() {
    Answerer answerer;
    for (;;) {
        std::unique_ptr<Connection> connection;
        {
            std::unique_lock lock(mutex_);
            wake_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
            if (stopping_) return;
            connection = std::move(waiting_.front());
            waiting_.pop_front();
        }
        answerer.answer(*connection->exchange, !connection->close_after);
        done_(std::move(connection));
    }
}

}  // namespace photond::http

#include "server/routes/answer_pool.h"

#include <poll.h>

#include <algorithm>

#include "server/helper_wait.h"
#include "server/routes/connection.h"
#include "server/steady_seconds.h"
#include "server/try_later.h"

namespace photond::http {
namespace {

constexpr int kRetryAfter_seconds = 5;

/// Whether the other end has closed the connection: nobody reads the answer. One that only ended its sending looks the
/// same and is taken for gone, as by other servers.
bool has_gone(const Connection& connection) {
    pollfd watched{connection.socket.get(), POLLRDHUP, 0};
    return poll(&watched, 1, 0) > 0 && (watched.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

/// Three quarters of something, one at least: what a single client may have of a lane.
size_t most_of(size_t all) { return std::max<size_t>(1, all - all / 4); }

}  // namespace

AnswerPool::AnswerPool(LaneSettings settings, LaneCallbacks callbacks)
    : settings_(settings),
      callbacks_(std::move(callbacks)),
      waiting_({settings.max_waiting, most_of(settings.max_waiting), most_of(settings.threads)}) {
    for (size_t i = 0; i < settings_.threads; ++i) threads_.emplace_back([this] { run(); });
}

AnswerPool::~AnswerPool() { stop(); }

bool AnswerPool::submit(std::unique_ptr<Connection>& connection) {
    {
        const std::lock_guard lock(mutex_);
        if (stopping_) return false;
        Waiting one{std::move(connection), Clock::now()};
        if (!waiting_.push(client_of(one.connection->exchange->call), one)) {
            connection = std::move(one.connection);
            return false;
        }
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
    may_wait_for_helper() = settings_.waits_for_helper;
    Answerer answerer;
    std::optional<FairQueue<Waiting>::Taken> taken;
    for (;;) {
        {
            std::unique_lock lock(mutex_);
            if (taken) {
                waiting_.finished(taken->client);
                taken.reset();
            }
            // Another thread may sleep over what this client could not be given before.
            if (waiting_.size() > 0) wake_.notify_one();
            wake_.wait(lock, [&] {
                if (!stopping_) taken = waiting_.take();
                return stopping_ || taken;
            });
            if (stopping_) return;
        }
        Connection& connection = *taken->item.connection;
        if (has_gone(connection)) {
            taken->item.connection.reset();
            callbacks_.gone();
            continue;
        }
        Exchange& exchange = *connection.exchange;
        const auto now = Clock::now();
        if (now - taken->item.since > steady_seconds(settings_.most_wait_seconds))
            exchange.refusal.emplace(Refusal{Error(ErrorCode::Unavailable, "the request waited too long for its turn"),
                                             {{"Retry-After", std::to_string(kRetryAfter_seconds)}}});
        const auto until = now + steady_seconds(settings_.most_work_seconds);
        exchange.call.before_piece = [&connection, until](uint64_t bytes) {
            if (has_gone(connection)) throw ClientGone();
            if (Clock::now() > until) throw TryLater("the answer takes longer than it may", kRetryAfter_seconds);
            connection.exchange->memory->take(bytes);
        };
        answerer.answer(exchange, !connection.close_after);
        if (exchange.needs_helper) {
            exchange.needs_helper = false;
            if (callbacks_.needs_helper(taken->item.connection)) continue;
            exchange.refusal.emplace(too_many_waiting());
            answerer.answer(exchange, !connection.close_after);
        }
        if (exchange.awaits) {
            callbacks_.awaits_job(std::move(taken->item.connection));
        } else if (exchange.client_gone) {
            taken->item.connection.reset();
            callbacks_.gone();
        } else {
            callbacks_.done(std::move(taken->item.connection));
        }
    }
}

}  // namespace photond::http

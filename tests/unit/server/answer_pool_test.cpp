// A lane's threads: what they answer, what they drop, and what they put off.

#include "server/routes/answer_pool.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <future>

#include "server/helper_wait.h"
#include "server/routes/connection.h"

namespace photond::http::answer_pool_test {
namespace {

class AnswerPoolTest : public testing::Test {
protected:
    /// A request of `client`; the other end of its socket goes to `other_end`.
    std::unique_ptr<Connection> request(const Route& route, const std::string& client, FileDescriptor& other_end) {
        int ends[2];
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
        other_end = FileDescriptor(ends[1]);
        auto connection = std::make_unique<Connection>(FileDescriptor(ends[0]), client, open_);
        connection->exchange = std::make_unique<Exchange>(busy_);
        Exchange& exchange = *connection->exchange;
        exchange.call.head = parse_head("GET /x HTTP/1.1\r\nHost: localhost\r\n\r\n");
        exchange.call.peer = client;
        exchange.route = &route;
        exchange.memory.emplace(memory_, client_of(exchange.call));
        return connection;
    }

    LaneCallbacks callbacks() {
        return {.done =
                    [this](std::unique_ptr<Connection> connection) {
                        const std::lock_guard lock(mutex_);
                        answered_.push_back(std::move(connection));
                        changed_.notify_all();
                    },
                .gone =
                    [this] {
                        const std::lock_guard lock(mutex_);
                        ++gone_;
                        changed_.notify_all();
                    }};
    }
    void wait_for(size_t answered, size_t gone) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return answered_.size() == answered && gone_ == gone; });
    }

    AnswerMemory memory_{1 << 20};
    std::atomic<int64_t> open_{0}, busy_{0};
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::unique_ptr<Connection>> answered_;
    size_t gone_ = 0;
};

TEST_F(AnswerPoolTest, AClientThatHasGoneIsNotServed) {
    std::atomic<int> worked{0};
    std::promise<void> let_go;
    const std::shared_future<void> gate = let_go.get_future().share();
    const Route slow{.handle = [&](Call&) { return gate.wait(), ++worked, Reply{}; }};
    AnswerPool pool({.threads = 1, .max_waiting = 100, .most_wait_seconds = 60, .most_work_seconds = 60}, callbacks());
    std::vector<FileDescriptor> ends(21);
    for (FileDescriptor& end : ends) {
        auto connection = request(slow, "a", end);
        ASSERT_TRUE(pool.submit(connection));
    }
    for (size_t i = 1; i < 20; ++i) ends[i].reset();
    let_go.set_value();
    wait_for(2, 19);
    EXPECT_EQ(worked, 2);
    EXPECT_EQ(open_, 2);
}

// Begun anew where threads may wait for a helper; put off where there is no room for it.
TEST_F(AnswerPoolTest, WhatNeedsAHelperIsAnsweredWhereOneIsWaitedFor) {
    std::atomic<int> begun{0};
    const Route route{.handle = [&](Call& call) {
        EXPECT_EQ(call.query.count("x"), 1u);
        ++begun;
        if (!may_wait_for_helper()) throw NeedsHelper();
        Reply reply;
        reply.body = "made";
        return reply;
    }};
    AnswerPool patient(
        {.threads = 1, .max_waiting = 1, .most_wait_seconds = 60, .most_work_seconds = 60, .waits_for_helper = true},
        callbacks());
    std::atomic<bool> room{true};
    LaneCallbacks quick_callbacks = callbacks();
    quick_callbacks.needs_helper = [&](std::unique_ptr<Connection>& connection) {
        return room && patient.submit(connection);
    };
    AnswerPool quick({.threads = 1, .max_waiting = 2, .most_wait_seconds = 60, .most_work_seconds = 60},
                     quick_callbacks);
    FileDescriptor ends[2];
    for (size_t i = 0; i < 2; ++i) {
        auto connection = request(route, "a", ends[i]);
        connection->exchange->call.head.query = "x=1";
        room = i == 0;
        ASSERT_TRUE(quick.submit(connection));
        wait_for(i + 1, 0);
    }
    EXPECT_EQ(begun, 3);
    EXPECT_EQ(answered_[0]->exchange->reply.status, 200);
    EXPECT_TRUE(answered_[0]->exchange->wire.ends_with("\r\n\r\nmade")) << answered_[0]->exchange->wire;
    EXPECT_EQ(answered_[1]->exchange->reply.status, 503);
    EXPECT_EQ(answered_[1]->exchange->reply.headers.at("Retry-After"), "1");
}

// The client leaves while its list is being made: the rest of it is not.
TEST_F(AnswerPoolTest, ALongAnswerEndsWhenItsClientGoes) {
    FileDescriptor end;
    int pieces = 0;
    const Route list{.handle = [&](Call& call) {
        return json_text_reply(call, [&](const auto& write) {
            for (; pieces < 100; ++pieces) {
                if (pieces == 3) end.reset();
                write("piece");
            }
        });
    }};
    AnswerPool pool({.threads = 1, .max_waiting = 1, .most_wait_seconds = 60, .most_work_seconds = 60}, callbacks());
    auto connection = request(list, "a", end);
    ASSERT_TRUE(pool.submit(connection));
    wait_for(0, 1);
    EXPECT_EQ(pieces, 3);
    EXPECT_EQ(memory_.bytes(), 0u);
}

TEST_F(AnswerPoolTest, WhatWaitedTooLongIsPutOff) {
    std::atomic<int> worked{0};
    const Route slow{.handle = [&](Call&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        return ++worked, Reply{};
    }};
    AnswerPool pool({.threads = 1, .max_waiting = 100, .most_wait_seconds = 0.01, .most_work_seconds = 60},
                    callbacks());
    std::vector<FileDescriptor> ends(10);
    for (FileDescriptor& end : ends) {
        auto connection = request(slow, "a", end);
        ASSERT_TRUE(pool.submit(connection));
    }
    wait_for(10, 0);
    EXPECT_LT(worked, 10);
    EXPECT_EQ(answered_.back()->exchange->reply.status, 503);
    EXPECT_EQ(answered_.back()->exchange->reply.headers.count("Retry-After"), 1u);
}

TEST_F(AnswerPoolTest, ALongAnswerHasADeadlineAndItsRoom) {
    const auto status_of = [&](double most_work_seconds, size_t piece_bytes) {
        const Route list{.handle = [&](Call& call) {
            return json_text_reply(call, [&](const auto& write) {
                for (int i = 0; i < 20; ++i) {
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
                    write(std::string(piece_bytes, ' '));
                }
            });
        }};
        FileDescriptor end;
        AnswerPool pool(
            {.threads = 1, .max_waiting = 1, .most_wait_seconds = 60, .most_work_seconds = most_work_seconds},
            callbacks());
        auto connection = request(list, "a", end);
        EXPECT_TRUE(pool.submit(connection));
        wait_for(1, 0);
        const int status = answered_.back()->exchange->reply.status;
        answered_.clear();
        return status;
    };
    EXPECT_EQ(status_of(60, 1000), 200);
    EXPECT_EQ(status_of(0.005, 1000), 503);
    AnswerMemory::Share others(memory_, "address b");
    others.take(900'000);
    EXPECT_EQ(status_of(60, 1000), 200);
    EXPECT_EQ(status_of(60, 20'000), 503);
}

// One client's requests, however many, leave a thread and a place for another's.
TEST_F(AnswerPoolTest, OneClientDoesNotHaveTheWholeLane) {
    std::promise<void> let_go;
    const std::shared_future<void> gate = let_go.get_future().share();
    const Route stuck{.handle = [&](Call&) { return gate.wait(), Reply{}; }},
        quick{.handle = [](Call&) { return Reply{}; }};
    AnswerPool pool({.threads = 4, .max_waiting = 8, .most_wait_seconds = 60, .most_work_seconds = 60}, callbacks());
    std::vector<FileDescriptor> ends(100);
    size_t taken = 0;
    for (FileDescriptor& end : ends) {
        auto connection = request(stuck, "a", end);
        taken += pool.submit(connection);
    }
    EXPECT_LE(taken, 3u + 6u);
    FileDescriptor end;
    auto connection = request(quick, "b", end);
    ASSERT_TRUE(pool.submit(connection));
    wait_for(1, 0);
    let_go.set_value();
    wait_for(1 + taken, 0);
}

}  // namespace
}  // namespace photond::http::answer_pool_test

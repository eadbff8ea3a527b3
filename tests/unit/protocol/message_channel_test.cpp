// Line-framed JSON over a socket: whole messages arrive whole, however the bytes are cut; what is no message closes the
// channel.

#include "protocol/message_channel.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <set>
#include <thread>

namespace photond::message_channel_test {
namespace {

using nlohmann::json;

class MessageChannelTest : public testing::Test {
protected:
    void SetUp() override { ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets_), 0); }
    void TearDown() override { close(sockets_[0]), close_peer(); }
    void close_peer() {
        if (sockets_[1] >= 0) close(sockets_[1]);
        sockets_[1] = -1;
    }
    void write_raw(const std::string& bytes) {
        ASSERT_EQ(::send(sockets_[1], bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
    }
    int sockets_[2] = {-1, -1};
};

TEST_F(MessageChannelTest, CutsAndJoinsDoNotMatter) {
    MessageChannel channel(sockets_[0]);
    write_raw("{\"type\":\"a\"}\n{\"type\":\"b\"}\n{\"ty");
    EXPECT_EQ(channel.receive(1000)->at("type"), "a");
    EXPECT_EQ(channel.receive(1000)->at("type"), "b");
    EXPECT_FALSE(channel.receive(10));
    EXPECT_FALSE(channel.closed());  // a timeout, not the end
    write_raw("pe\":\"c\"}\n");
    EXPECT_EQ(channel.receive(1000)->at("type"), "c");
    write_raw("{\"type\":\"last\"}\n");
    close_peer();
    EXPECT_EQ(channel.receive(-1)->at("type"), "last");
    EXPECT_FALSE(channel.receive(-1));
    EXPECT_TRUE(channel.closed());
    EXPECT_FALSE(channel.send({{"type", "x"}}));
}

TEST_F(MessageChannelTest, WhatIsNoMessageClosesTheChannel) {
    for (const std::string line : {"not json\n", "[1, 2]\n", "{\"a\":1,\"a\":2}\n", "7\n"}) {
        int pair[2];
        ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
        MessageChannel channel(pair[0]);
        ASSERT_EQ(::send(pair[1], line.data(), line.size(), 0), ssize_t(line.size()));
        EXPECT_FALSE(channel.receive(1000)) << line;
        EXPECT_TRUE(channel.closed()) << line;
        close(pair[0]), close(pair[1]);
    }
}

TEST_F(MessageChannelTest, ALineWithoutEndClosesTheChannel) {
    MessageChannel channel(sockets_[0]);
    std::thread flood([this] {
        const std::string chunk(1 << 16, 'x');
        for (size_t sent = 0; sent < 2 * kMaxMessageBytes;) {
            const ssize_t n = ::send(sockets_[1], chunk.data(), chunk.size(), MSG_NOSIGNAL);
            if (n <= 0) return;
            sent += size_t(n);
        }
    });
    EXPECT_FALSE(channel.receive(-1));
    EXPECT_TRUE(channel.closed());
    shutdown(sockets_[0], SHUT_RDWR);
    flood.join();
}

TEST_F(MessageChannelTest, ManyThreadsSendWholeLines) {
    MessageChannel sender(sockets_[1]), receiver(sockets_[0]);
    constexpr int kThreads = 4, kEach = 200;
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([&sender, t] {
            for (int i = 0; i < kEach; ++i)
                EXPECT_TRUE(sender.send({{"id", t * kEach + i}, {"padding", std::string(size_t(i * 37), 'p')}}));
        });
    std::set<int> ids;
    for (int i = 0; i < kThreads * kEach; ++i) {
        const auto message = receiver.receive(5000);
        ASSERT_TRUE(message);
        ids.insert(message->at("id").get<int>());
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(ids.size(), size_t(kThreads * kEach));
}

TEST_F(MessageChannelTest, TextThatIsNotUtf8IsReplaced) {
    MessageChannel sender(sockets_[1]), receiver(sockets_[0]);
    EXPECT_TRUE(sender.send({{"name",
                              "a\xff"
                              "b\n"}}));
    EXPECT_EQ(receiver.receive(1000)->at("name"),
              "a\xEF\xBF\xBD"
              "b\n");
}

}  // namespace
}  // namespace photond::message_channel_test

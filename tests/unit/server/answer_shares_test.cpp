// What clients share: turns in a lane, and the memory for answers that are not read yet.

#include <gtest/gtest.h>

#include <memory>

#include "server/routes/answer_memory.h"
#include "server/routes/fair_queue.h"
#include "server/try_later.h"

namespace photond::http::answer_shares_test {
namespace {

bool push(FairQueue<int>& queue, const std::string& client, int item) { return queue.push(client, item); }

TEST(FairQueue, GivesClientsTheirTurnsOneAfterAnother) {
    FairQueue<int> queue({.waiting = 100, .waiting_per_client = 50, .taken_per_client = 50});
    for (int i = 0; i < 50; ++i) ASSERT_TRUE(push(queue, "many", i));
    ASSERT_TRUE(push(queue, "a", 100));
    ASSERT_TRUE(push(queue, "b", 200));
    ASSERT_TRUE(push(queue, "a", 101));
    std::vector<int> order;
    for (int i = 0; i < 7; ++i) order.push_back(queue.take()->item);
    EXPECT_EQ(order, (std::vector{0, 100, 200, 1, 101, 2, 3}));
    EXPECT_EQ(queue.size(), 46u);
}

TEST(FairQueue, NoClientHasAllPlaces) {
    FairQueue<int> queue({.waiting = 4, .waiting_per_client = 3, .taken_per_client = 9});
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(push(queue, "a", i));
    EXPECT_FALSE(push(queue, "a", 3));
    EXPECT_TRUE(push(queue, "b", 4));
    EXPECT_FALSE(push(queue, "c", 5)) << "all places are taken";
    queue.take();
    EXPECT_TRUE(push(queue, "c", 5));
}

TEST(FairQueue, LeavesWhatItDoesNotTakeWhereItIs) {
    FairQueue<std::unique_ptr<int>> queue({.waiting = 1, .waiting_per_client = 1, .taken_per_client = 1});
    auto first = std::make_unique<int>(1), second = std::make_unique<int>(2);
    EXPECT_TRUE(queue.push("a", first));
    EXPECT_FALSE(first);
    EXPECT_FALSE(queue.push("a", second));
    EXPECT_TRUE(second);
}

TEST(FairQueue, NoClientHasAllHands) {
    FairQueue<int> queue({.waiting = 100, .waiting_per_client = 50, .taken_per_client = 2});
    for (int i = 0; i < 10; ++i) push(queue, "a", i);
    EXPECT_EQ(queue.take()->item, 0);
    EXPECT_EQ(queue.take()->item, 1);
    EXPECT_FALSE(queue.take()) << "two are in hand";
    push(queue, "b", 100);
    EXPECT_EQ(queue.take()->item, 100);
    EXPECT_FALSE(queue.take());
    queue.finished("a");
    EXPECT_EQ(queue.take()->item, 2);
    queue.finished("b");
    queue.finished("a");
    queue.clear();
    EXPECT_FALSE(queue.take());
    EXPECT_EQ(queue.size(), 0u);
    queue.finished("a");
    EXPECT_TRUE(push(queue, "a", 1));
    EXPECT_EQ(queue.take()->item, 1);
}

constexpr uint64_t kMost = 800;

TEST(AnswerMemory, HoldsNoMoreThanThereIsRoomFor) {
    AnswerMemory memory(kMost);
    AnswerMemory::Share a(memory, "a"), b(memory, "b");
    a.take(400);
    b.take(400);
    EXPECT_EQ(memory.bytes(), kMost);
    EXPECT_FALSE(memory.was_short());
    EXPECT_THROW(b.take(1), TryLater);
    EXPECT_TRUE(memory.was_short());
    EXPECT_FALSE(memory.was_short()) << "it was told";
    EXPECT_EQ(memory.bytes(), kMost);
    a.give_back(400);
    b.take(1);
    b.give_back(1000);  // more than there is
    EXPECT_EQ(b.bytes(), 0u);
    EXPECT_EQ(memory.bytes(), 0u);
}

TEST(AnswerMemory, NoClientFillsMoreThanHalf) {
    AnswerMemory memory(kMost);
    AnswerMemory::Share first(memory, "a"), second(memory, "a"), other(memory, "b");
    first.take(300);
    second.take(100);
    EXPECT_THROW(second.take(1), TryLater);
    other.take(400);
    EXPECT_EQ(memory.bytes(), kMost);
}

// An answer that is longer than all the memory there is for answers would never be given otherwise.
TEST(AnswerMemory, AnAnswerAloneMayBeAsLongAsItIs) {
    AnswerMemory memory(kMost);
    AnswerMemory::Share crumb(memory, "a"), whole(memory, "a"), other(memory, "b");
    crumb.take(kMost / 8);
    for (int i = 0; i < 30; ++i) whole.take(100);
    EXPECT_EQ(whole.bytes(), 3000u);
    EXPECT_THROW(other.take(1), TryLater) << "not beside another";
}

TEST(AnswerMemory, WhatHasToBeHeldIsCounted) {
    AnswerMemory memory(kMost);
    {
        AnswerMemory::Share a(memory, "a"), b(memory, "b");
        a.take(kMost);
        b.hold(500);
        EXPECT_EQ(memory.bytes(), kMost + 500);
    }
    EXPECT_EQ(memory.bytes(), 0u);
}

// Else each of a thousand requests would be half answered before it is told that there is no room.
TEST(AnswerMemory, WhoFoundNoRoomDoesNotBeginAgainAtOnce) {
    AnswerMemory memory(kMost);
    AnswerMemory::Share unread(memory, "a"), other(memory, "b");
    unread.take(350);
    {
        AnswerMemory::Share next(memory, "a");
        next.take(0);
        next.take(50);
        EXPECT_THROW(next.take(50), TryLater);
    }
    AnswerMemory::Share again(memory, "a");
    EXPECT_THROW(again.take(0), TryLater);
    EXPECT_NO_THROW(other.take(50)) << "that was the other's share";
    unread.give_back(300);
    EXPECT_NO_THROW(again.take(50)) << "there is room again";
}

}  // namespace
}  // namespace photond::http::answer_shares_test

// The order of waiting jobs, and what a lost attempt leads to.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "server/queue/job_queue.h"
#include "server/queue/retry_policy.h"

namespace photond::queue_test {
namespace {

TEST(JobQueue, HigherPriorityFirstThenFirstComeFirstServed) {
    struct Item {
        int64_t seq;
        int priority;
    };
    std::vector<Item> items;
    for (int64_t seq = 1; seq <= 500; ++seq) items.push_back({seq, static_cast<int>(seq * 37 % 11) - 5});
    std::vector<Item> expected = items;
    std::stable_sort(expected.begin(), expected.end(), [](auto& a, auto& b) { return a.priority > b.priority; });
    std::shuffle(items.begin(), items.end(), std::mt19937(1));

    JobQueue queue;
    for (const Item& item : items) queue.push(item.seq, item.priority, "cpu");
    for (const Item& item : items) queue.push(item.seq, 100, "gpu:0");  // there already: nothing happens
    EXPECT_EQ(queue.size(), items.size());
    for (const Item& item : expected) {
        ASSERT_EQ(queue.front("cpu"), item.seq);
        ASSERT_TRUE(queue.remove(item.seq));
    }
    EXPECT_FALSE(queue.front("cpu"));
    EXPECT_EQ(queue.size(), 0u);
}

TEST(JobQueue, DevicesDoNotWaitForEachOther) {
    JobQueue queue;
    queue.push(1, 100, "cpu");
    queue.push(2, 0, "gpu:0");
    EXPECT_EQ(queue.front("gpu:0"), 2);
    EXPECT_EQ(queue.front("cpu"), 1);
    EXPECT_FALSE(queue.front("gpu:1"));
    EXPECT_FALSE(queue.remove(3));
}

TEST(JobQueue, SomeWaitForTheEndOfAnother) {
    JobQueue queue;
    queue.push(1, 0, "cpu");
    queue.hold(2, 5, "cpu", 1);
    queue.hold(3, 9, "gpu:0", 1);
    queue.hold(4, 9, "cpu", 2);
    EXPECT_EQ(queue.size(), 4u) << "those that wait count";
    EXPECT_EQ(queue.waits_for(3), 1);
    EXPECT_FALSE(queue.waits_for(1));
    queue.push(2, 7, "cpu");  // held already: nothing happens
    EXPECT_EQ(queue.front("cpu"), 1) << "whatever the priority of those held";
    EXPECT_FALSE(queue.front("gpu:0"));
    EXPECT_TRUE(queue.remove(1));
    EXPECT_EQ(queue.release(1), (std::vector<int64_t>{2, 3}));
    EXPECT_EQ(queue.front("cpu"), 2);
    EXPECT_EQ(queue.front("gpu:0"), 3);
    EXPECT_FALSE(queue.waits_for(3)) << "no more";
    EXPECT_TRUE(queue.release(1).empty()) << "once";
    EXPECT_TRUE(queue.remove(4)) << "one that is held can be cancelled";
    EXPECT_TRUE(queue.release(2).empty());
    EXPECT_EQ(queue.size(), 2u);
    queue.hold(2, 0, "cpu", 9);  // in the queue already: nothing happens
    EXPECT_EQ(queue.front("cpu"), 2);
}

TEST(JobQueue, AJobWhosePriorityChangedIsPutInAgain) {
    JobQueue queue;
    for (int64_t seq = 1; seq <= 3; ++seq) queue.push(seq, 0, "cpu");
    queue.hold(4, 0, "cpu", 9);
    queue.remove(3);
    queue.push(3, 5, "cpu");
    EXPECT_EQ(queue.front("cpu"), 3);
    queue.remove(3);
    queue.push(3, -5, "cpu");
    EXPECT_EQ(queue.front("cpu"), 1) << "among equals the older first";
    queue.remove(4);
    queue.hold(4, 7, "cpu", 9);
    EXPECT_EQ(queue.front("cpu"), 1) << "one that waits for another stays beside the queue";
    EXPECT_EQ(queue.release(9), (std::vector<int64_t>{4}));
    EXPECT_EQ(queue.front("cpu"), 4) << "and comes into it with its new priority";
    EXPECT_EQ(queue.size(), 4u);
}

TEST(RetryPolicy, FollowsTheProtocol) {
    // Lost through no fault of its own: at most two further attempts.
    EXPECT_FALSE(failure_after(AttemptEnd::Lost, 1, 0));
    EXPECT_FALSE(failure_after(AttemptEnd::Lost, 2, 1));
    EXPECT_EQ(failure_after(AttemptEnd::Lost, 3, 0), ErrorCode::WorkerLost);
    // By its own signal: once more.
    EXPECT_FALSE(failure_after(AttemptEnd::Crashed, 2, 1));
    EXPECT_EQ(failure_after(AttemptEnd::Crashed, 0, 2), ErrorCode::WorkerCrashed);
    // Its GPU lost: once more likewise, and two attempts in all with crashes among them.
    EXPECT_FALSE(failure_after(AttemptEnd::DeviceLost, 2, 1));
    EXPECT_EQ(failure_after(AttemptEnd::DeviceLost, 0, 2), ErrorCode::DeviceLost);
    // At once.
    EXPECT_EQ(failure_after(AttemptEnd::OutOfMemory, 0, 0), ErrorCode::OutOfMemory);
    EXPECT_EQ(failure_after(AttemptEnd::NoSpace, 0, 0), ErrorCode::NoSpace);
    EXPECT_EQ(failure_after(AttemptEnd::TimedOut, 0, 0), ErrorCode::TimedOut);
}

}  // namespace
}  // namespace photond::queue_test

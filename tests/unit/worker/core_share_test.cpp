// Whether a job had its cores: what is added up while its clock runs, from readings that are given here, and what
// follows.

#include "server/worker/core_share.h"

#include <gtest/gtest.h>

#include <cmath>

namespace photond::core_share_test {
namespace {

class CoreShareTest : public testing::Test {
protected:
    CoreSample now{10, std::map<int, double>{{1, 5.0}, {2, 1.0}}, HostTime{1000, 3}, 70.0};
    CoreShare cores{[this] { return now; }};
};

TEST_F(CoreShareTest, AddsUpWhatIsOnTheClock) {
    cores.pause(), cores.resume(), cores.look();  // before it runs
    now.process_seconds = 11;
    cores.begin();
    now = {14, std::map<int, double>{{1, 5.25}, {2, 1.5}}, HostTime{1005, 3.5}, 71.0};
    cores.pause();
    now = {20, std::map<int, double>{{1, 9}, {2, 9}}, HostTime{2000, 9}, 90.0};
    cores.resume();
    now = {21, std::map<int, double>{{1, 9.5}, {2, 9}}, HostTime{2003, 9}, 90.25};
    cores.end();
    now = {99, std::map<int, double>{{1, 99}, {2, 99}}, HostTime{9999, 99}, 999.0};
    cores.pause(), cores.resume(), cores.look();  // after it
    const CoreUse use = cores.sums();
    EXPECT_DOUBLE_EQ(use.processor_seconds, 3 + 1);
    EXPECT_DOUBLE_EQ(use.run_delay_seconds.value(), 0.75 + 0.5);
    EXPECT_DOUBLE_EQ(use.host_busy_outside_seconds.value(), (5 - 3) + (3 - 1));
    EXPECT_DOUBLE_EQ(use.host_steal_seconds.value(), 0.5);
    EXPECT_DOUBLE_EQ(use.pressure_seconds.value(), 1.25);
}

TEST_F(CoreShareTest, ThreadsComeAndGo) {
    cores.begin();
    now.delays = std::map<int, double>{{2, 1.5}, {3, 0.25}};  // 1 has ended, 3 is new
    cores.look();
    now.delays = std::map<int, double>{{2, 0.125}, {3, 0.5}};  // another thread was given number 2
    EXPECT_DOUBLE_EQ(cores.sums().run_delay_seconds.value(), (0.5 + 0.25) + (0.125 + 0.25));
}

TEST_F(CoreShareTest, WhatTheKernelLacksIsNotKnown) {
    cores.begin();
    now.delays.reset(), now.pressure_seconds.reset();
    cores.look();
    now.delays = std::map<int, double>{{1, 6}}, now.pressure_seconds = 80;
    const CoreUse use = cores.sums();
    EXPECT_FALSE(use.run_delay_seconds || use.pressure_seconds);
    EXPECT_TRUE(use.host_busy_outside_seconds);
}

TEST(CoreShare, ThisProcessHasAtMostWhatItsThreadsCanHave) {
    CoreShare cores;
    cores.begin();
    volatile double work = 1;
    for (int i = 0; i < 3'000'000; ++i) work = work * 1.0000001;
    cores.end();
    EXPECT_GT(cores.sums().processor_seconds, 0);
    if (cores.sums().run_delay_seconds) {
        EXPECT_GE(*cores.sums().run_delay_seconds, 0);
    }
}

CoreUse derived(double had, std::optional<double> waited, std::optional<double> outside, double clock) {
    CoreUse use;
    use.processor_seconds = had, use.run_delay_seconds = waited, use.host_busy_outside_seconds = outside;
    use.derive(clock, 2);
    return use;
}

TEST(CoreUse, SaysWhatWasLostToOthers) {
    // Two threads on two cores for 10 s beside one busy loop.
    EXPECT_DOUBLE_EQ(derived(10, 10, 10, 10).share.value(), 0.5);
    // Four threads on two cores, alone: they wait for each other.
    EXPECT_DOUBLE_EQ(derived(20, 20, 0, 10).share.value(), 1);
    EXPECT_DOUBLE_EQ(derived(20, 20, 0, 10).lost_seconds.value(), 0);
    // The same four threads beside one busy loop.
    EXPECT_DOUBLE_EQ(derived(10, 30, 10, 10).share.value(), 0.5);
    // One thread on two cores beside one busy loop: nobody waits.
    EXPECT_DOUBLE_EQ(derived(9.99, 0.01, 10, 10).share.value(), 0.999);
    // A job that waits for its GPU: 20 ms of 10 s, though its thread had but 30 ms.
    EXPECT_DOUBLE_EQ(derived(0.03, 0.02, 5, 10).share.value(), 0.998);
    // Readings in ticks can say that less than nothing ran outside.
    EXPECT_DOUBLE_EQ(derived(10, 1, -0.02, 10).lost_seconds.value(), 0);
    EXPECT_DOUBLE_EQ(derived(0, 0.0, 0.0, 0).share.value(), 1) << "nothing was wanted";
    EXPECT_FALSE(derived(10, {}, 3, 10).share);
    // On two processors: two threads that lost half their time, one thread that did, and one that seldom runs.
    EXPECT_DOUBLE_EQ(derived(10, 10, 10, 10).clock_lost_seconds.value(), 5);
    EXPECT_DOUBLE_EQ(derived(5, 5, 10, 10).clock_lost_seconds.value(), 5);
    EXPECT_DOUBLE_EQ(derived(0.5, 0.25, 10, 10).clock_lost_seconds.value(), 0.25);
    EXPECT_DOUBLE_EQ(derived(20, 1, 1, 10).clock_lost_seconds.value(), 0);
    EXPECT_DOUBLE_EQ(derived(9, 1, {}, 5).share.value(), 0.9);
}

TEST(CoreUse, AddsUpOverAttempts) {
    CoreUse sum = derived(1, 2, 3, 4);
    sum += derived(10, 20, 30, 40);
    EXPECT_EQ(sum.processor_seconds, 11);
    EXPECT_EQ(sum.run_delay_seconds, 22);
    EXPECT_EQ(sum.host_busy_outside_seconds, 33);
    EXPECT_FALSE(sum.pressure_seconds) << "what is not known of a part is not known of the whole";
}

}  // namespace
}  // namespace photond::core_share_test

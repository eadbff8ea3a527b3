// When the host counts as quiet, from readings that are given here.

#include "server/service/quiet_machine.h"

#include <gtest/gtest.h>

namespace photond::quiet_machine_test {
namespace {

using namespace std::chrono_literals;

class QuietMachineTest : public testing::Test {
protected:
    std::optional<double> busy = 100;
    QuietMachine machine{2, [this] { return busy; }};
    QuietMachine::Clock::time_point now{};

    /// A look after each 0.25 s, in which so much was busy.
    std::optional<double> load_after(int looks, double busy_each) {
        std::optional<double> load;
        for (int i = 0; i < looks; ++i) {
            now += 250ms;
            *busy += busy_each;
            load = machine.load(now);
        }
        return load;
    }
};

TEST_F(QuietMachineTest, IsTheMeanOfTheLastTwoSeconds) {
    EXPECT_FALSE(machine.load(now));
    EXPECT_FALSE(load_after(7, 0.25)) << "1.75 s";
    EXPECT_DOUBLE_EQ(load_after(1, 0.25).value(), 0.5) << "one of two processors";
    EXPECT_DOUBLE_EQ(load_after(4, 0).value(), 0.25);
    EXPECT_DOUBLE_EQ(load_after(4, 0).value(), 0);
    EXPECT_NEAR(load_after(1, 0.02).value(), 0.005, 1e-9);
}

TEST_F(QuietMachineTest, WhatWasLongAgoDoesNotCount) {
    machine.load(now);
    load_after(8, 0);
    now += 3s;
    EXPECT_FALSE(machine.load(now));
}

TEST_F(QuietMachineTest, IsQuietWhereTheKernelDoesNotSay) {
    busy.reset();
    EXPECT_EQ(machine.load(now), 0);
}

}  // namespace
}  // namespace photond::quiet_machine_test

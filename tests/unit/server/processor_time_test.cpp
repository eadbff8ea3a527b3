// The kernel's texts about processor time, as they are and as they should not be.

#include "server/processor_time.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <string>
#include <thread>

namespace photond::processor_time_test {
namespace {

constexpr double kTick = 0.01;

TEST(ProcessorTime, ReadsWhatTheHostsProcessorsDid) {
    const auto time = parse_host_time("cpu  100 20 30 4000 500 6 7 8 90 1\ncpu0 1 1 1 1 1 1 1 1 1 1\nintr 1\n", kTick);
    ASSERT_TRUE(time);
    EXPECT_DOUBLE_EQ(time->busy_seconds, 1.63) << "neither idle nor waiting for a disk; guests are among user and nice";
    EXPECT_DOUBLE_EQ(time->steal_seconds, 0.08);
    for (const char* wrong :
         {"", "cpu", "cpu0 1 2 3 4 5 6 7 8", "cpu  1 2 3 4 5 6 7", "cpu  1 2 x 4 5 6 7 8", "memory 1"})
        EXPECT_FALSE(parse_host_time(wrong, kTick)) << wrong;
}

TEST(ProcessorTime, ReadsPressure) {
    EXPECT_DOUBLE_EQ(parse_pressure_seconds("some avg10=51.63 avg60=50.09 avg300=43.15 total=2052065214\n"
                                            "full avg10=0.00 avg60=0.00 avg300=0.00 total=7\n")
                         .value(),
                     2052.065214);
    for (const char* wrong :
         {"", "some", "full avg10=0.00 total=7\n", "some total=\n", "some avg10=0.00\nfull total=3\n"})
        EXPECT_FALSE(parse_pressure_seconds(wrong)) << wrong;
}

TEST(ProcessorTime, ReadsHowLongAThreadWaited) {
    EXPECT_DOUBLE_EQ(parse_run_delay_seconds("9000000000 2500000000 77\n").value(), 2.5);
    for (const char* wrong : {"", "1", "1 2", "a b c", "-1 2 3"}) EXPECT_FALSE(parse_run_delay_seconds(wrong)) << wrong;
}

TEST(ProcessorTime, ThisKernelSaysAllOfItOrNothing) {
    if (const auto time = host_time()) {
        EXPECT_GT(time->busy_seconds, 0);
    }
    if (const auto pressure = pressure_seconds()) {
        EXPECT_GE(*pressure, 0);
    }
    std::atomic<bool> end = false;
    std::thread other([&] { end.wait(false); });
    if (const auto delays = run_delays()) {
        EXPECT_EQ(delays->size(), 2u);
        EXPECT_TRUE(delays->contains(getpid())) << "the first thread has the process' number";
    }
    end = true;
    end.notify_all();
    other.join();
    EXPECT_GT(processor_seconds_of(getpid()).value(), 0);
    EXPECT_FALSE(processor_seconds_of(-1));
}

}  // namespace
}  // namespace photond::processor_time_test

// What jobs may hold where address space is bounded.

#include "server/workers/address_space.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "protocol/error.h"

namespace photond::address_space_test {
namespace {

constexpr uint64_t kMachine = 8ull << 30, kMiB = 1ull << 20;
constexpr uint64_t kBeside = 1408 * kMiB;  // 256 of libraries, 1024, and 64 of each of two threads

TEST(AddressSpace, DecidesNothingWhereItIsAmple) {
    EXPECT_EQ(memory_limit_within(UINT64_MAX, 0, kMachine, 2), 6ull << 30);
    EXPECT_EQ(memory_limit_within(UINT64_MAX, 5, kMachine, 2), 5u);
    EXPECT_EQ(memory_limit_within(kBeside + kMachine, 0, kMachine, 2), 6ull << 30);
}

TEST(AddressSpace, LeavesJobsWhatTheWorkerItselfDoesNotMap) {
    EXPECT_EQ(memory_limit_within(2048 * kMiB, 0, kMachine, 2), 640 * kMiB);
    EXPECT_EQ(memory_limit_within(2048 * kMiB, 0, kMachine, 4), 512 * kMiB);
    EXPECT_EQ(memory_limit_within(2048 * kMiB, 640 * kMiB, kMachine, 2), 640 * kMiB);
    EXPECT_EQ(memory_limit_within(kBeside + 256 * kMiB, 0, kMachine, 2), 256 * kMiB);
}

TEST(AddressSpace, ThatIsTooSmallSaysWhatIsNeeded) {
    const auto text = [](uint64_t granted, uint64_t asked) -> std::string {
        try {
            memory_limit_within(granted, asked, kMachine, 2);
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::OutOfMemory);
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(
        text(400'000 << 10, 0),
        "a process is granted 400000 KiB of address space (ulimit -v); photond needs 1703936: 1441792 for a worker "
        "of 2 threads and 262144 for what its jobs hold (--memory-limit)");
    EXPECT_NE(text(kBeside + 256 * kMiB - 1, 0), "");
    EXPECT_NE(text(2048 * kMiB, 640 * kMiB + 1).find("655361 for what its jobs hold"), std::string::npos);
}

TEST(AddressSpace, IsReadFromTheSystem) {
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &limit), 0);
    EXPECT_EQ(granted_address_space(), limit.rlim_cur);
}

}  // namespace
}  // namespace photond::address_space_test

// The tests that compare numbers of threads really run on them.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include "renderer/core/parallel.h"
#include "tests/support/threads.h"

namespace photond::on_threads_test {
namespace {

/// Greatest number of tasks at work at once, of `tasks` that wait for each other as long as `patience`, or else until
/// all are at work.
int most_at_once(int threads, int tasks, std::optional<std::chrono::milliseconds> patience = std::nullopt) {
    std::atomic<int> running = 0, most = 0;
    test::on_threads(threads, [&] {
        parallel_for(static_cast<size_t>(tasks), 1, [&](size_t) {
            ++running;
            const auto begun = std::chrono::steady_clock::now();
            do {
                most = std::max(most.load(), running.load());
                std::this_thread::yield();
            } while (most < tasks && !(patience && std::chrono::steady_clock::now() - begun > *patience));
            --running;
        });
    });
    return most;
}

TEST(OnThreads, WorkRunsOnAsManyAlsoAfterASingleOne) {
    using std::chrono::milliseconds;
    EXPECT_EQ(most_at_once(1, 4, milliseconds(2)), 1);
    EXPECT_EQ(most_at_once(2, 2), 2);
    EXPECT_EQ(most_at_once(8, 8), 8);
    EXPECT_LE(most_at_once(2, 4, milliseconds(50)), 2);  // the second may come late on a busy machine, a third never
}

}  // namespace
}  // namespace photond::on_threads_test

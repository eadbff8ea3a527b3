#pragma once
// Runs work on a given number of threads, also when the machine has fewer cores or the test has run on others before.

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace photond::test {

/// What `work` returns, run on that many threads (>= 1). In an arena of its own: that of the caller's thread stays as
/// wide as it was when first used, and work that follows a single thread's would never really run on more.
template <class Work>
auto on_threads(int threads, const Work& work) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute(work);
}

}  // namespace photond::test

#pragma once
// Parallel loops over TBB. Results must not depend on how the work is divided.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <future>

namespace photond {

/// Calls body(i) for each i in [0, count); `grain` is the least number of calls a thread takes at once.
template <class Body>
void parallel_for(size_t count, size_t grain, const Body& body) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i != range.end(); ++i) body(i);
    });
}

/// Calls both, perhaps at the same time.
template <class First, class Second>
void parallel_invoke(const First& first, const Second& second) {
    tbb::parallel_invoke(first, second);
}

/// Calls work() beside what the caller goes on with, its loops on as many threads as the caller's.
template <class Work>
auto run_beside(const Work& work) {
    return std::async(std::launch::async, [work, threads = tbb::this_task_arena::max_concurrency()] {
        tbb::task_arena arena(threads);
        return arena.execute(work);
    });
}

}  // namespace photond

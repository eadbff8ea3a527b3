#pragma once
// Scratch space of threads. Whatever is kept here must not show in the result.

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace photond {

/// One T for each thread that asks for `local()`, made by the first call; iterates over all that were made.
template <class T>
using ThreadLocal = tbb::enumerable_thread_specific<T>;

/// The most threads a parallel loop started here may use.
inline size_t most_threads() { return static_cast<size_t>(tbb::this_task_arena::max_concurrency()); }

}  // namespace photond

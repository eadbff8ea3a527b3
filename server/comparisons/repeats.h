#pragma once
// Which job counts where a comparison's job was disturbed and repeated.

#include <cstddef>
#include <span>

#include "server/comparisons/table.h"

namespace photond {

/// Of `runs`, the job that was planned and its repeats in the order they were made, the one that stands in the tables:
/// the first that succeeded undisturbed, else the least disturbed that succeeded, else the one that was planned.
size_t run_that_counts(std::span<const MeasuredJob> runs);

/// Whether the daemon runs it again by itself: all are over, the last has succeeded and was disturbed, none that has
/// succeeded was not, and there are fewer than `most` repeats.
bool is_to_be_repeated(std::span<const MeasuredJob> runs, size_t most);

}  // namespace photond

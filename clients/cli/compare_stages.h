#pragma once
// Where the time of each pass goes, beside what was published of the same stages.

#include <iosfwd>
#include <span>

#include "clients/cli/compare_presets.h"
#include "clients/cli/compare_statistics.h"

namespace photond::cli {

/// A line a stage, published and measured milliseconds of each of `published.rows`: a pass's, or a job's where the
/// stage is done once. On a GPU its own clock counts, where it has timed the stage. A stage that was neither published
/// nor timed is left out. Nothing where none of those rows is there.
void print_published_stages(std::ostream& out, std::span<const RowStatistics> rows, const PublishedStages& published);

}  // namespace photond::cli

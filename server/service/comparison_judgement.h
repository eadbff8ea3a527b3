#pragma once
// What follows from a comparison's row and its jobs: its state, its table, its verdicts and headlines. A comparison has
// no state of its own.

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "server/comparisons/measured_job.h"
#include "server/comparisons/table.h"
#include "server/store/store.h"

namespace photond {

/// Where the jobs are, and those that they are measured against.
struct ComparisonState {
    std::vector<JobProgress> jobs;  // repeats after all that were planned
    /// One that was named, or the two films of a reference; several such where jobs differ (references_of()).
    std::vector<JobProgress> references;
    std::vector<JobProgress> own_references;  // of these, those made for this comparison

    /// The state of each place, in their order: that of a repeat that is not over, else `succeeded` where any job there
    /// has, else that of the job that was planned.
    std::vector<JobState> places() const;
    /// The state that the places come to; a reference that is being made for them counts as begun.
    JobState state() const;
    /// Of all references; empty where they are no jobs. That of the one that is not over, or has not succeeded, first.
    std::optional<JobState> reference_state() const;
};

/// All that any of the jobs is measured against, each once, in the order in which they come to it. It is the same for
/// all, unless it was lost and made anew for some, or a job is repeated by a daemon that makes references otherwise.
std::vector<int64_t> references_of(const std::vector<JobProgress>& jobs);

/// All that is known of a comparison and its jobs.
struct Compared {
    ComparisonRow row;
    ComparisonState state;
    std::vector<std::pair<ComparisonJob, JobRow>> jobs;
    std::vector<JobRow> references;  // as in `state`
    std::vector<RowBias> biases;     // that have been measured
};

/// What follows from that.
struct Judged {
    nlohmann::json object;
    std::vector<MeasuredJob> jobs;           // those that count, one a place
    std::vector<nlohmann::json> statistics;  // of these, or null
    ComparisonTable table;
};

/// Pure functions, which take long: without the lock.
Judged judge(const Compared& compared);
/// The object without jobs and tables.
nlohmann::json comparison_summary(const ComparisonRow& row, const ComparisonState& state);

}  // namespace photond

#pragma once
// Who is first to which error: what the time-to-error tables come to, in plain sentences.

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "server/comparisons/table.h"

namespace photond {

/// Which rows reach an error of a metric, and in what order.
struct Verdict {
    std::string metric;
    double error = 0;                 // the smallest of the table's levels of which it is true
    double easiest = 0;               // the largest
    std::vector<size_t> arrived;      // rows that reach `error` with every seed, quickest first; never empty
    std::vector<size_t> missing;      // those that do not
    bool close = false;               // who is first cannot be told
    std::vector<size_t> rivals = {};  // rows that arrived and cannot be told apart from the first, by their times
    /// Rows with disturbed jobs that might have been there first, had these had all processors that they wanted.
    std::vector<size_t> doubtful = {};
    /// Rows that do not reach it as far as the references' noise shows, and by their lower ends might have been first.
    std::vector<size_t> open = {};
    double seconds(const ComparisonTable& table, size_t row) const { return time(table, row).seconds->mean; }
    const TimeToError& time(const ComparisonTable& table, size_t row) const;
};

/// Only where their intervals say so, those over the seeds or, of single seeds, what the references' noise leaves open:
/// not where these overlap, or the times are equal, nor where both rows were there before the first measurement, nor
/// where the later might have been as soon with the processors that it lost. Both rows reach the error.
bool can_be_told_apart(const TimeToError& a, const TimeToError& b);

/// For each metric by falling error; levels after each other with the same outcome share a verdict, that of the
/// smallest. Empty for a table of one row, which nothing can be said of.
std::vector<Verdict> verdicts(const ComparisonTable& table);

/// "photon mapping reaches relative_mse 0.01 first, after 1.2 s: 3.75 times sooner than path tracing (4.5 s)"; of rows
/// that do not reach it because of their bias (floor_of()) what they come to instead; and of rows that are marked
/// (left_out_marks.h) that they are.
std::string verdict_text(const ComparisonTable& table, const Verdict& verdict);

/// [{"metric", "error", "easiest", "close", "factor", "arrived": [{"row", "seconds"}], "missing": [row],
/// "disturbed": [row], "text"}]; a row is its index in the table, the factor the second's time over the first's.
nlohmann::json verdicts_json(const ComparisonTable& table, std::span<const Verdict> verdicts);

}  // namespace photond

#pragma once
// The tables of a report, as HTML.

#include <string>

#include "server/comparisons/table.h"

namespace photond {

/// Rows over levels of error, each cell the time to reach it and its interval; the first marked.
std::string time_to_error_table(const ComparisonTable& table, const std::string& metric);
/// Rows over times, each cell the error then; the lowest marked.
std::string error_at_time_table(const ComparisonTable& table, const std::string& metric);
/// What each row took and came to: passes, time and its spread, final errors beside the reference's noise, memory,
/// efficiency, and whether it is on the Pareto front.
std::string cost_table(const ComparisonTable& table);

}  // namespace photond

#pragma once
// A comparison's curves as a table for a spreadsheet (RFC 4180).

#include <span>
#include <string>
#include <vector>

#include "server/comparisons/table.h"

namespace photond {

/// A line for each point of each job's curve: label, parameters (JSON), seed, job, seconds, passes, photons, then
/// `metrics` and whatever else was measured, by name; last, of each of these that has intervals anywhere, their ends as
/// "NAME least" and "NAME greatest". What was not measured at a point, or has no value, is empty.
std::string report_csv(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics);

}  // namespace photond

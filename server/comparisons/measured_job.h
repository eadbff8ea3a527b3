#pragma once
// A job as the tables take it, from what the store holds of it.

#include <nlohmann/json.hpp>
#include <string>

#include "server/comparisons/table.h"

namespace photond {

/// Fills in what a job has measured: `curve` is its array of points or null, `statistics` its statistics or null, both
/// as on the wire (protocol.md, "Shapes").
void add_measurements(MeasuredJob& job, const nlohmann::json& curve, const nlohmann::json& statistics);

}  // namespace photond

#pragma once
// A comparison for people: tables of speed against error, and in plain sentences who is first.

#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>

namespace photond::cli {

/// "photon mapping, photons 5000" of a row or job of a comparison: its label and what the sweep gave it.
std::string comparison_row_name(const nlohmann::json& row);

/// For every metric time to error and error at time, each figure with its 95 % interval over the seeds or, of one seed,
/// with what the references' noise leaves open, an error that is not positive as its upper bound; then each row's last
/// errors, memory, efficiency and whether it is on the Pareto front, what is known of the references' noise, and what
/// rows' errors are made of. `comparison`: protocol.md, "Shapes".
void print_comparison_tables(std::ostream& out, const nlohmann::json& comparison);

/// Says which jobs were disturbed, what became of that, and how those that count are run again.
void print_disturbances(std::ostream& out, const nlohmann::json& comparison);
/// Prints for each metric that has a headline that headline, after a blank line, and beneath it, by falling error, the
/// daemon's sentences on who is first.
void print_verdicts(std::ostream& out, const nlohmann::json& comparison);

}  // namespace photond::cli

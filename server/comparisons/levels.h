#pragma once
// Round numbers for tables and axes: 1, 2, 5 times powers of ten.

#include <vector>

namespace photond {

/// Those in [low, high], rising; both positive. Each is the double nearest to its decimal.
std::vector<double> round_levels(double low, double high);
/// The smallest that is at least `value` > 0.
double round_level_above(double value);

}  // namespace photond

#include "server/comparisons/levels.h"

#include <cassert>
#include <cmath>
#include <cstdlib>
#include <string>

namespace photond {
namespace {

/// Number i of the series, 1 at i = 0.
double level(int i) {
    const int decade = i >= 0 ? i / 3 : -((2 - i) / 3);
    static constexpr const char* kSteps[] = {"1", "2", "5"};
    return std::strtod((std::string(kSteps[i - 3 * decade]) + "e" + std::to_string(decade)).c_str(), nullptr);
}

int first_at_least(double value) {
    assert(value > 0 && std::isfinite(value));
    int i = 3 * static_cast<int>(std::floor(std::log10(value))) - 3;
    while (level(i) < value) ++i;
    return i;
}

}  // namespace

std::vector<double> round_levels(double low, double high) {
    std::vector<double> levels;
    for (int i = first_at_least(low); level(i) <= high; ++i) levels.push_back(level(i));
    return levels;
}

double round_level_above(double value) { return level(first_at_least(value)); }

}  // namespace photond

#pragma once
// Where a figure lies, as far as it is known.

namespace photond {

/// Of an estimate: what its level of confidence says stands with the estimate (kConfidence where nothing is said).
struct Interval {
    double least = 0, greatest = 0;

    bool operator==(const Interval&) const = default;
};

}  // namespace photond

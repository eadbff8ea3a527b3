#pragma once
// The filters of FLIP as one-dimensional weights: contrast sensitivity of the eye in the three opponent channels, and
// the edge and point detectors. All are products, or sums of two products, of a filter along x and one along y.
// [Andersson et al. 2020, Sec. 4.1 and 4.2]

#include <array>
#include <cstddef>
#include <vector>

namespace photond {

/// Weights at 0, 1, .. radius; at -k the same, or for a derivative the same with its sign turned.
using HalfFilter = std::vector<float>;

struct FlipFilters {
    HalfFilter achromatic, red_green;  // add up to 1 over -radius .. radius
    /// The kernel is the sum over both of w(x) w(y), and that sum is what is normalised to 1.
    std::array<HalfFilter, 2> blue_yellow;
    HalfFilter gaussian;  // of the detectors, across their direction; adds up to 1
    HalfFilter edge;      // first derivative, odd: the weights at positive offsets add up to 1, its centre is 0
    HalfFilter point;     // second derivative: positive weights add up to 1, negative to -1
    size_t radius;        // the largest of all
};

/// `pixels_per_degree` >= 1. Weights of the eye's filters that together make less than 2^-26 of their sum are left out:
/// below the rounding of a float.
FlipFilters make_flip_filters(double pixels_per_degree);

}  // namespace photond

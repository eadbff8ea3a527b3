#pragma once
// What can be said of an image's error without a reference: from the variance between its passes.
//
// Passes of a low-discrepancy sequence are not independent: their variance over n overstates the error of the mean. The
// shape of the error over the image is taken from the between-pass variance, its scale from two halves of the passes.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// Mean over values of var / (x^2 + 0.01 m^2): the relative_mse to be expected of an image x whose values have these
/// variances (of the mean, not of one pass). Empty when the mean m of x is 0 or nothing is known of the variances.
std::optional<double> expected_relative_mse(std::span<const float> image, std::span<const float> variance_of_mean);

struct ErrorEstimate {
    double estimated_relative_mse = 0;
    /// Factor on sqrt(pass variance / passes) that makes it each value's standard error; 1 for independent passes.
    double standard_error_scale = 1;
};

/// Follows one film as its passes add up; keeps one earlier state of the image (12 bytes a pixel).
class ErrorEstimator {
public:
    static uint64_t bytes_for(Size2 size) { return size.pixels() * 3 * sizeof(float); }

    /// The beauty after `passes` passes (rising from call to call) and the unbiased variance between passes of one
    /// pass's value. Empty before two passes. Independent of which passes it was called at, up to the choice of the
    /// halves that it could compare.
    std::optional<ErrorEstimate> update(uint32_t passes, std::span<const float> image,
                                        std::span<const float> pass_variance);

private:
    /// What one comparison of halves, after that many passes, gave: E (A - B)^2 over what independent passes would.
    struct Level {
        double log2_passes = 0;
        double ratio = 1;
    };
    /// Of log2 ratio over log2 passes. Scrambled nets integrate functions with jumps in d dimensions with a variance of
    /// n^-(1 + 1/(2d - 1)) [He and Wang 2015]; an edge across a pixel has d = 2.
    static constexpr double kLeastSlope = -1.0 / 3;

    void compare_halves(uint32_t passes, std::span<const float> image, std::span<const float> pass_variance);
    double variance_ratio(uint32_t passes) const;

    uint32_t last_passes_ = 0;
    uint32_t half_passes_ = 0;
    std::vector<float> half_;  // the mean of the first half_passes_
    std::array<Level, 4> levels_;
    size_t level_count_ = 0;
};

/// Share of the values, of those whose standard error is known and not 0, whose reference lies within z standard errors
/// of the image; the reference's own standard error is added in quadrature where it is given. Empty when there are
/// none.
std::optional<double> share_within(std::span<const float> image, std::span<const float> standard_error,
                                   std::span<const float> reference, std::span<const float> reference_standard_error,
                                   double z);
/// Two-sided 90 % of a normal distribution.
inline constexpr double kConfidence = 0.90;
inline constexpr double kConfidenceZ = 1.6448536269514722;

/// A reference as another rendering of the same quality would be: with noise of its own standard error added, drawn by
/// `seed`. A metric of this against the reference is the part of any measured value that the reference's noise
/// explains.
std::vector<float> with_own_noise(std::span<const float> reference, std::span<const float> standard_error,
                                  uint64_t seed);

}  // namespace photond

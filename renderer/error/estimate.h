#pragma once
// What can be said of an image's error without a reference: from the variance between its passes.
//
// Passes of a low-discrepancy sequence are not independent: their variance s^2 over n overstates the error of the mean.
// The shape of the error over the image is taken from the between-pass variance, its scale from two halves of the
// passes: with A the mean of the first m and B that of the other n - m,
//
//   f^2 = sum w (A - B)^2 / sum w s^2 (1/m + 1/(n - m)),   w the weights of relative_mse,
//
// is 1 for independent passes, and standard error = f s / sqrt(n). A value that one pass alone makes gives both sums
// the same: rare paths draw f to 1, as they should. The ratios of the last four levels (each twice the passes of the
// one before) are smoothed by a line through their logarithms; its value at n is f^2, between levels as well. With V(n)
// the variance of a net's mean, E (A - B)^2 = 4 (V(n/2) - V(n)) where m = n/2: f^2 estimates V(n) without bias where V
// falls as 1/n. Where it falls as n^-p the ratio is too large by 2^p - 1; p is 1.1 in a Cornell box, which makes the
// estimated mean square 15 % too large. Dividing by that was measured and left out: with the slope's noise, and its
// sign known, it made estimates 20 to 30 % too low at 64 passes (32x32 pixels), the side that matters.
// Measured, mean of 8 seeds, estimated over true relative_mse at 64, 128, 256 passes: cornell-box 0.97, 1.00, 1.25;
// cornell-box-spot 0.94, 0.92, 1.29; s^2 / n itself is up to twice too large there. Where paths are rare it is far too
// low, like s^2 itself: tests/statistical/error/error_estimate_test.cpp lists the scenes.
//
// Bias is not in it: photon mapping's images differ from the truth by more than is said here. A method whose pixels
// share photons has few independent values, and its f is as noisy.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// Mean over values of var / (r^2 + 0.01 m^2), r^2 = max(x^2 - var, 0): the relative_mse to be expected of an image x
/// of mean m whose values have these variances (of the mean, not of one pass). E x^2 is r^2 + var: with x^2 itself the
/// rare path that a large variance comes from would weigh its own error down. Values whose variance is not finite are
/// left out. Empty when m is 0 or nothing is known of the variances.
std::optional<double> expected_relative_mse(std::span<const float> image, std::span<const float> variance_of_mean);

struct ErrorEstimate {
    double estimated_relative_mse = 0;
    /// Factor on sqrt(pass variance / passes) that makes it each value's standard error; 1 for independent passes.
    double standard_error_scale = 1;
};

/// Follows one film as its passes add up; keeps one earlier state of the image (12 bytes a pixel). Call it at all
/// powers of two, and wherever else an estimate is wanted: halves are kept at powers of two, and compared once there
/// are twice as many passes. Before that (fewer than four passes, a film that was taken up again) the scale is 1.
class ErrorEstimator {
public:
    static uint64_t bytes_for(Size2 size) { return size.pixels() * 3 * sizeof(float); }

    /// The beauty after `passes` passes (rising from call to call) and the unbiased variance between passes of one
    /// pass's value (empty for one pass). Empty before two passes and for a black image. Independent of which passes it
    /// was called at, up to the choice of the halves that it could compare.
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
/// explains. Values whose standard error is infinite or NaN (nothing is known of it) get no noise. Gaussian, a pure
/// function of (seed, index).
std::vector<float> with_own_noise(std::span<const float> reference, std::span<const float> standard_error,
                                  uint64_t seed);

}  // namespace photond

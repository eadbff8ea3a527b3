#pragma once
// An image against two references of one truth: their noise drops out of every quadratic measure (believing-errors.md,
// "Two films").
//
// A is the image, biased or not, I the truth; U and V are films of an unbiased method with different seeds. With
// x = A - U and y = A - V the mean of x y is that of (A - I)^2, whatever the noise of U and V. It may be negative near
// zero. A is what is measured, so that its spread over pixels is no error of sampling: the interval is of the
// references' noise alone, whose pixels are taken for independent, as those of path tracing with a box filter are. With
// a = A - I and s^2 the variance of a reference's value, that of x y is 2 a^2 s^2 + s^4 whatever the distribution. Two
// sums over pixels are at least that in the mean, and the lesser of both is taken:
//
//   q^2, q the sum of (x^2 - y^2) / (2 D) over a pixel's channels: right where noise is normal, and too large by its
//   excess of fourth moments where rare values are bright;
//   (t - the mean of t)^2, t the sum of x y / D: too large by how a^2 is spread over the image, and so right where the
//   references' noise is what there is: no bright value of one of them is at a pixel where the other one has one.
//
// What relative_mse divides by is the references' alone, b^2 + 0.01 m^2 with m the mean of R = (U + V) / 2: an image's
// own fireflies would forgive themselves. It is chosen once, by the references, for all images, times and seeds. b is R
// where R's noise allows that. D then shares the pixel's noise; with e = A - R, d = (U - V) / 2, nu = d^2 / D and
// rho = R^2 / D what that adds to the mean is, to second order in the relative variance of R, the mean of
//
//   4 nu e R / D - 2/3 nu^2 (4 rho - 1),
//
// and it is taken off. (For an even bias beta of A it is 4 nu beta, a fifth of the figure where nu is 5e-4 and beta
// 1 %; for a perfect image 6 nu^2.) What stays is 3 nu of the figure and some nu^3: with b = R the mean of nu is at
// most 1/300, and three times the mean of nu^3 at most a tenth of the half-width of a perfect image's interval.
// Elsewhere b is the mean of the 5x5 neighbours of R, the pixel itself left out: its noise is another.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/error/estimate.h"
#include "renderer/error/interval.h"
#include "renderer/error/metric.h"

namespace photond {

struct CrossError {
    double value = 0;           // not clamped: may be negative
    double standard_error = 0;  // by the references' noise

    /// Two-sided, kConfidence.
    Interval interval() const { return {value - kConfidenceZ * standard_error, value + kConfidenceZ * standard_error}; }
};

/// Where b is taken from.
enum class Denominators : uint8_t { Pixel, Neighbours };

struct CrossErrors {
    /// Empty where no value is left; relative_mse also where m is 0.
    std::optional<CrossError> mse, relative_mse;
    Denominators denominators = Denominators::Pixel;  // of relative_mse, the references' choice
    uint64_t left_out = 0;                            // values that are not finite in one of the three
};

/// One metric as it is shown.
struct CrossFigure {
    std::optional<double> value;  // none for the root of what is estimated below 0
    Interval interval;            // of a root the roots of its ends, 0 for those below
    Denominators denominators = Denominators::Pixel;
};

/// Whether a metric is a mean of squares, or the root of one: those are measured so.
bool is_quadratic(Metric metric);
/// `metric`: a quadratic one (asserted). Empty where CrossErrors has none.
std::optional<CrossFigure> figure_of(const CrossErrors& errors, Metric metric);

/// Measures images of one layer: scene-linear RGB, interleaved, row 0 at the top. Thread-safe.
class CrossMeter {
public:
    /// Each of 3 * size.pixels() values (asserted); what `u` and `v` show is independent of each other.
    CrossMeter(Size2 size, const std::vector<float>& u, const std::vector<float>& v);

    Size2 size() const { return size_; }
    /// R = (U + V) / 2, and (U - V) / 2.
    std::span<const float> mean_reference() const { return mean_reference_; }
    std::span<const float> half_difference() const { return half_difference_; }
    /// m: 0 where nothing is relative.
    double mean() const { return mean_; }
    Denominators denominators() const { return denominators_; }
    /// unit^2 / D of each value, `unit` a power of two near m that keeps it within floats; all 0 where m is 0.
    std::span<const float> weights() const { return weights_; }
    double unit() const { return unit_; }
    /// Of what it keeps.
    uint64_t bytes() const {
        return sizeof(float) * (mean_reference_.size() + half_difference_.size() + weights_.size());
    }

    /// `image`: of the references' size (asserted).
    CrossErrors measure(std::span<const float> image) const;

private:
    struct Sums;
    class Sweep;
    double mean_of_neighbours(size_t value) const;
    Denominators choose() const;

    const Size2 size_;
    const std::vector<float> mean_reference_, half_difference_;
    double mean_ = 0, unit_ = 1;
    Denominators denominators_ = Denominators::Pixel;
    std::vector<float> weights_;
};

}  // namespace photond

#pragma once
// An image against a reference: every measure of conventions.md, "Error". Images are one layer's pixels: scene-linear
// RGB, interleaved, row 0 at the top, three floats a pixel.

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/error/flip.h"
#include "renderer/error/metric.h"

namespace photond {

/// What one sweep over the pixels gives. A value is empty where its definition divides by a mean of r that is 0, or
/// where no value is left. Values where x or r is not finite are left out of every mean and counted.
class PointwiseErrors {
public:
    /// Of a metric that is not costly: its value, or its three by channel.
    std::optional<double>& operator[](Metric metric) { return channels(metric)[0]; }
    const std::optional<double>& operator[](Metric metric) const { return channels(metric)[0]; }
    std::array<std::optional<double>, 3>& channels(Metric metric) { return values_[static_cast<size_t>(metric)]; }
    const std::array<std::optional<double>, 3>& channels(Metric metric) const {
        return values_[static_cast<size_t>(metric)];
    }
    /// All of a metric's values, as many as MetricInfo::values says; empty where one of them is.
    std::vector<double> values_of(Metric metric) const;

    /// The factors s on x that fitted_rmse and fitted_relative_mse are the least of. None where x is black everywhere.
    std::optional<double> least_squares_exposure, relative_least_squares_exposure;
    uint64_t left_out = 0;  // values (not pixels)

private:
    std::array<std::array<std::optional<double>, 3>, kMetrics.size()> values_{};
};

/// Measures images of one layer against one reference, and keeps whatever of that depends on the reference alone.
/// rmse_8bit compares display values as real numbers: clamped to 0..255, not rounded. A negative m, which light does
/// not have, counts by its magnitude in smape. The fitted squares are exact to some 1e-7 of the mean square of x - r or
/// of r, whichever is less: what the fit leaves is a difference of sums. Thread-safe.
class ErrorMeter {
public:
    /// `reference`: 3 * size.pixels() values.
    ErrorMeter(Size2 size, std::vector<float> reference);
    ~ErrorMeter();

    Size2 size() const { return size_; }
    std::span<const float> reference() const { return reference_; }
    /// m: mean of r over pixels and channels, its finite values.
    double reference_mean() const { return mean_; }

    /// All below take an image of the reference's size (asserted).
    PointwiseErrors pointwise(std::span<const float> image) const;
    /// Each pixel's relative error: the root of its mean over channels of (x - r)^2 / (r^2 + 0.01 m^2); NaN where a
    /// value is not finite. Empty when m = 0.
    std::vector<double> relative_errors(std::span<const float> image) const;
    /// Percentiles 50, 90, 99, 100 (the smallest value that at least so many percent of the pixels do not exceed) of
    /// the pixels' relative errors, those that are numbers. Empty when there are none.
    std::optional<std::array<double, 4>> percentiles(std::span<const float> image) const;
    /// Pixels whose luminance exceeds 100 x (median of their 5x5 neighbours + 0.01 m). The neighbourhood is cut at the
    /// image's edge and leaves out its centre and what is not finite.
    uint64_t firefly_count(std::span<const float> image) const;
    FlipMap flip_ldr(std::span<const float> image) const;
    FlipMap flip_hdr(std::span<const float> image) const;

    /// The metric's values as many as MetricInfo::values says; empty where the definition gives none (m = 0), `why`
    /// then says so. `metric` needs a reference.
    std::vector<double> measure(Metric metric, std::span<const float> image, std::string* why = nullptr) const;

private:
    const Flip& flip(std::unique_ptr<const Flip>& made, FlipRange range) const;

    const Size2 size_;
    const std::vector<float> reference_;
    double mean_ = 0;
    std::array<double, 3> channel_means_{};
    const std::vector<float> encoded_;  // the reference as sRGB, 0 to 1: display values over 255
    mutable std::mutex flip_mutex_;
    mutable std::unique_ptr<const Flip> flip_ldr_, flip_hdr_;  // made when first asked for
};

}  // namespace photond

// ErrorMeter::firefly_count(): pixels far above the median of their neighbours.

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "renderer/core/parallel.h"
#include "renderer/core/rgb.h"
#include "renderer/error/error_meter.h"

namespace photond {

namespace {

constexpr size_t kReach = 2;  // 5x5
constexpr size_t kSide = 2 * kReach + 1;
constexpr double kFireflyFactor = 100, kMeanShare = 0.01;

/// Luminance with a margin of kReach on every side; the margin and pixels that are not finite are +infinity, which is
/// below no threshold.
class LuminancePlane {
public:
    LuminancePlane(Size2 size, std::span<const float> image)
        : size_(size), stride_(size.width + 2 * kReach), values_(stride_ * (size.height + 2 * kReach), kInfinity) {
        parallel_for(size.height, 8, [&](size_t y) {
            const float* in = &image[3 * y * size.width];
            float* out = &values_[(y + kReach) * stride_ + kReach];
            for (size_t x = 0; x < size.width; ++x) {
                const Rgb color(in[3 * x], in[3 * x + 1], in[3 * x + 2]);
                if (is_finite(color)) out[x] = luminance(color);
            }
        });
    }

    Size2 size() const { return size_; }
    /// Values of row y (from -kReach on, shifted by it) and its column -kReach.
    const float* padded_row(size_t y) const { return &values_[y * stride_]; }
    float at(size_t x, size_t y) const { return padded_row(y + kReach)[x + kReach]; }

    /// Median of what is finite around a pixel, without itself; of an even number the mean of the two in the middle.
    std::optional<double> neighbours_median(size_t x, size_t y) const {
        std::array<float, kSide * kSide> found;
        size_t count = 0;
        for (size_t j = 0; j < kSide; ++j)
            for (size_t i = 0; i < kSide; ++i) {
                const float value = padded_row(y + j)[x + i];
                if ((i != kReach || j != kReach) && value < kInfinity) found[count++] = value;
            }
        if (count == 0) return std::nullopt;
        const auto end = found.begin() + count, middle = found.begin() + count / 2;
        std::nth_element(found.begin(), middle, end);
        if (count % 2 == 1) return double{*middle};
        return 0.5 * (double{*std::max_element(found.begin(), middle)} + double{*middle});
    }

private:
    Size2 size_;
    size_t stride_;
    std::vector<float> values_;
};

/// Counts one row. L exceeds 100 (median + 0.01 m) only where at least half of the neighbours lie below
/// t = L / 100 - 0.01 m; that is counted for whole rows at once, and few pixels are left to take the median of.
class RowScan {
public:
    RowScan(const LuminancePlane& plane, double mean)
        : plane_(plane),
          mean_(mean),
          threshold_(plane.size().width),
          below_(plane.size().width),
          finite_(plane.size().width) {}

    uint64_t count(size_t y) {
        set_thresholds(y);
        count_below(y);
        uint64_t fireflies = 0;
        for (size_t x = 0; x < threshold_.size(); ++x)
            if (below_[x] > 0 && 2 * below_[x] >= finite_[x] && is_firefly(x, y)) ++fireflies;
        return fireflies;
    }

private:
    /// t, rounded up by more than the errors of computing it in float.
    void set_thresholds(size_t y) {
        const auto offset = static_cast<float>(kMeanShare * mean_);
        const float* row = plane_.padded_row(y + kReach) + kReach;
        for (size_t x = 0; x < threshold_.size(); ++x) {
            const float scaled = row[x] * static_cast<float>(1 / kFireflyFactor);
            const float slack = 1e-6f * (std::fabs(scaled) + std::fabs(offset)) + std::numeric_limits<float>::min();
            threshold_[x] = scaled < kInfinity ? scaled - offset + slack : -kInfinity;
        }
    }

    void count_below(size_t y) {
        std::fill(below_.begin(), below_.end(), 0);
        std::fill(finite_.begin(), finite_.end(), 0);
        for (size_t j = 0; j < kSide; ++j)
            for (size_t i = 0; i < kSide; ++i) {
                if (i == kReach && j == kReach) continue;
                const float* neighbour = plane_.padded_row(y + j) + i;
                for (size_t x = 0; x < threshold_.size(); ++x) {
                    below_[x] += neighbour[x] < threshold_[x] ? 1 : 0;
                    finite_[x] += neighbour[x] < kInfinity ? 1 : 0;
                }
            }
    }

    bool is_firefly(size_t x, size_t y) const {
        const std::optional<double> median = plane_.neighbours_median(x, y);
        return median && double{plane_.at(x, y)} > kFireflyFactor * (*median + kMeanShare * mean_);
    }

    const LuminancePlane& plane_;
    const double mean_;
    std::vector<float> threshold_;
    std::vector<int32_t> below_, finite_;
};

}  // namespace

uint64_t ErrorMeter::firefly_count(std::span<const float> image) const {
    assert(image.size() == reference_.size());
    if (size_.pixels() == 0) return 0;
    const LuminancePlane plane(size_, image);
    constexpr size_t kRows = 8;  // at a time
    std::vector<uint64_t> counts((size_.height + kRows - 1) / kRows);
    parallel_for(counts.size(), 1, [&](size_t band) {
        RowScan scan(plane, mean_);
        for (size_t y = band * kRows; y < std::min<size_t>(size_.height, (band + 1) * kRows); ++y)
            counts[band] += scan.count(y);
    });
    uint64_t total = 0;
    for (const uint64_t count : counts) total += count;
    return total;
}

}  // namespace photond

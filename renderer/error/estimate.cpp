#include "renderer/error/estimate.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>

#include "renderer/core/rng.h"
#include "renderer/error/pixel_chunks.h"

namespace photond {

namespace {

struct Mean {
    double sum = 0;
    uint64_t count = 0;

    void operator+=(const Mean& other) { sum += other.sum, count += other.count; }
    double value() const { return sum / static_cast<double>(count); }
};

/// Weights of relative_mse, 1 / (r^2 + 0.01 m^2), the image standing in for the reference. Where the variance v of its
/// value is large, x^2 is not r^2: E x^2 = r^2 + v, and the rare path that v comes from would take the weight from its
/// own error. So r^2 is x^2 - v, unbiased. Empty when m is 0 or there is no value.
class RelativeWeight {
public:
    static std::optional<RelativeWeight> of(std::span<const float> image) {
        const Mean mean = sum_of_chunks<Mean>(image.size(), [&](size_t first, size_t last) {
            Mean part;
            for (size_t i = first; i < last; ++i)
                if (std::isfinite(image[i])) part += {image[i], 1};
            return part;
        });
        if (mean.count == 0 || mean.sum == 0) return std::nullopt;
        return RelativeWeight(0.01 * mean.value() * mean.value());
    }
    double operator()(double x, double variance) const { return 1 / (std::max(x * x - variance, 0.0) + floor_); }

private:
    explicit RelativeWeight(double floor) : floor_(floor) {}
    double floor_;
};

/// Sums over the values, each weighted as in relative_mse.
struct HalvesSums {
    double squared_difference = 0;  // of the means of both parts
    double variance = 0;            // that independent passes would give it

    void operator+=(const HalvesSums& other) {
        squared_difference += other.squared_difference, variance += other.variance;
    }
};

/// Mean over values of scale * variance times their weight.
std::optional<double> relative_mse_of(std::span<const float> image, std::span<const float> variance, double scale) {
    assert(variance.size() == image.size());
    const std::optional<RelativeWeight> weight = RelativeWeight::of(image);
    if (!weight) return std::nullopt;
    const Mean mean = sum_of_chunks<Mean>(image.size(), [&](size_t first, size_t last) {
        Mean part;
        for (size_t i = first; i < last; ++i) {
            const double v = scale * variance[i];
            if (std::isfinite(image[i]) && std::isfinite(v)) part += {v * (*weight)(image[i], v), 1};
        }
        return part;
    });
    if (mean.count == 0) return std::nullopt;
    return mean.value();
}

}  // namespace

std::optional<double> expected_relative_mse(std::span<const float> image, std::span<const float> variance_of_mean) {
    return relative_mse_of(image, variance_of_mean, 1);
}

std::optional<ErrorEstimate> ErrorEstimator::update(uint32_t passes, std::span<const float> image,
                                                    std::span<const float> pass_variance) {
    assert(passes >= last_passes_ && (half_.empty() || half_.size() == image.size()));
    last_passes_ = passes;
    std::optional<ErrorEstimate> estimate;
    if (passes >= 2) {
        assert(pass_variance.size() == image.size());
        // Of two passes the difference and the variance are the same thing.
        if (half_passes_ >= 2 && passes >= 2 * half_passes_) compare_halves(passes, image, pass_variance);
        const double scale_sq = variance_ratio(passes);
        if (const std::optional<double> mse = relative_mse_of(image, pass_variance, scale_sq / passes))
            estimate = {*mse, std::sqrt(scale_sq)};
    }
    if (std::has_single_bit(passes) && passes != half_passes_) {
        half_passes_ = passes;
        half_.assign(image.begin(), image.end());
    }
    return estimate;
}

void ErrorEstimator::compare_halves(uint32_t passes, std::span<const float> image,
                                    std::span<const float> pass_variance) {
    const std::optional<RelativeWeight> weight = RelativeWeight::of(image);
    if (!weight) return;
    // With x = (m A + (n - m) B) / n: A - B = n / (n - m) (A - x).
    const double n = passes, m = half_passes_, to_difference = n / (n - m), independent = 1 / m + 1 / (n - m);
    const HalvesSums sums = sum_of_chunks<HalvesSums>(image.size(), [&](size_t first, size_t last) {
        HalvesSums part;
        for (size_t i = first; i < last; ++i) {
            const double x = image[i], difference = to_difference * (half_[i] - x);
            if (!std::isfinite(difference) || !std::isfinite(pass_variance[i])) continue;
            const double w = (*weight)(x, pass_variance[i] / n);
            part += {w * difference * difference, w * independent * pass_variance[i]};
        }
        return part;
    });
    if (!(sums.variance > 0)) return;  // every pass is alike
    if (level_count_ == levels_.size()) {
        std::shift_left(levels_.begin(), levels_.end(), 1);
        --level_count_;
    }
    levels_[level_count_++] = {std::log2(n), sums.squared_difference / sums.variance};
}

double ErrorEstimator::variance_ratio(uint32_t passes) const {
    const std::span<const Level> levels(levels_.data(), level_count_);
    if (levels.empty()) return 1;
    const double now = std::log2(passes);
    // Least squares of log2 ratio over log2 n.
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    for (const Level& level : levels) mean_x += level.log2_passes, mean_y += std::log2(level.ratio);
    mean_x /= static_cast<double>(levels.size()), mean_y /= static_cast<double>(levels.size());
    for (const Level& level : levels) {
        xx += (level.log2_passes - mean_x) * (level.log2_passes - mean_x);
        xy += (level.log2_passes - mean_x) * (std::log2(level.ratio) - mean_y);
    }
    // NaN of a level without any difference is no slope either.
    const double slope = xx > 0 && xy < 0 ? std::max(xy / xx, kLeastSlope) : 0;
    double sum = 0;
    for (const Level& level : levels) sum += level.ratio * std::exp2(slope * (now - level.log2_passes));
    return sum / static_cast<double>(levels.size());
}

std::optional<double> share_within(std::span<const float> image, std::span<const float> standard_error,
                                   std::span<const float> reference, std::span<const float> reference_standard_error,
                                   double z) {
    assert(standard_error.size() == image.size() && reference.size() == image.size());
    assert(reference_standard_error.empty() || reference_standard_error.size() == image.size());
    const Mean share = sum_of_chunks<Mean>(image.size(), [&](size_t first, size_t last) {
        Mean part;
        for (size_t i = first; i < last; ++i) {
            const double own = standard_error[i], difference = double{image[i]} - double{reference[i]};
            const double others = reference_standard_error.empty() ? 0 : double{reference_standard_error[i]};
            if (!(own > 0) || !std::isfinite(own) || !std::isfinite(others) || !std::isfinite(difference)) continue;
            part += {difference * difference <= z * z * (own * own + others * others) ? 1.0 : 0.0, 1};
        }
        return part;
    });
    if (share.count == 0) return std::nullopt;
    return share.value();
}

std::vector<float> with_own_noise(std::span<const float> reference, std::span<const float> standard_error,
                                  uint64_t seed) {
    assert(standard_error.size() == reference.size());
    std::vector<float> noisy(reference.begin(), reference.end());
    const auto add = [&](size_t i, float normal) {
        if (i < noisy.size() && std::isfinite(standard_error[i]) && std::isfinite(noisy[i]))
            noisy[i] += standard_error[i] * normal;
    };
    for_each_chunk((noisy.size() + 1) / 2, [&](size_t first, size_t last) {
        for (size_t pair = first; pair < last; ++pair) {
            // [Box and Muller 1958] A Note on the Generation of Random Normal Deviates. No pass has this number.
            RandomStream random(seed, RandomDomain::Reference, UINT32_MAX, pair);
            const float u = (static_cast<float>(random.next_bits()) + 0.5f) * 0x1p-32f;  // (0, 1]
            const float radius = std::sqrt(-2 * std::log(u)), angle = 2 * std::numbers::pi_v<float> * random.next();
            add(2 * pair, radius * std::cos(angle)), add(2 * pair + 1, radius * std::sin(angle));
        }
    });
    return noisy;
}

}  // namespace photond

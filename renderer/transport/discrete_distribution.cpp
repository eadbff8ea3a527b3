// [Chen and Asau 1974] On Generating Random Variates from an Empirical Distribution. AIIE Transactions 6.

#include "renderer/transport/discrete_distribution.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <string>

#include "protocol/error.h"

namespace photond {

namespace {

constexpr double kSteps = DiscreteDistribution::kMost;
constexpr uint64_t kMostGuides = 1u << 16;

/// A power of two: i / guides is exact.
uint64_t guides_for(uint64_t entries) { return std::min(std::bit_ceil(entries), kMostGuides); }

}  // namespace

DiscreteDistribution::DiscreteDistribution(std::span<const double> weights, std::span<const double> least) {
    assert(least.empty() || least.size() == weights.size());
    const auto least_steps = [&](size_t i) {
        if (!least.empty()) return std::max(std::ceil(least[i] * kSteps), weights[i] > 0 ? 1.0 : 0.0);
        return weights[i] > 0 ? 1.0 : 0.0;
    };
    double total = 0, taken = 0;
    for (size_t i = 0; i < weights.size(); ++i) total += weights[i], taken += least_steps(i);
    if (!(taken > 0)) return;
    if (taken > kSteps)
        throw Error(ErrorCode::Unsupported, "",
                    std::to_string(weights.size()) + " lights to choose from are more than " + std::to_string(kMost));
    cdf_.resize(weights.size() + 1);
    // Whole steps of the sums, so that rounding does not pile up.
    double below = 0, least_below = 0;
    for (size_t i = 0; i < weights.size(); ++i) {
        below += weights[i], least_below += least_steps(i);
        const double shared = total > 0 ? std::round((kSteps - taken) * (below / total)) : 0.0;
        cdf_[i + 1] = static_cast<float>((least_below + shared) / kSteps);
    }
    cdf_.back() = 1;

    const uint64_t guides = guides_for(weights.size());
    guide_.resize(guides + 1);
    uint32_t entry = 0;
    for (uint64_t i = 0; i <= guides; ++i) {
        const float u = static_cast<float>(i) / static_cast<float>(guides);
        while (entry + 1 < weights.size() && cdf_[entry + 1] <= u) ++entry;
        guide_[i] = entry;
    }
}

uint32_t DiscreteDistribution::sample(float u) const {
    const size_t guides = guide_.size() - 1;
    const size_t i = static_cast<size_t>(u * static_cast<float>(guides));
    const float* first = cdf_.data() + 1;
    return static_cast<uint32_t>(std::upper_bound(first + guide_[i], first + guide_[i + 1], u) - first);
}

uint64_t DiscreteDistribution::bytes() const {
    return cdf_.capacity() * sizeof(float) + guide_.capacity() * sizeof(uint32_t);
}

uint64_t DiscreteDistribution::bytes_for(uint64_t entries) {
    return (entries + 1) * sizeof(float) + (guides_for(entries) + 1) * sizeof(uint32_t);
}

}  // namespace photond

#pragma once
// Choice of one of many by a uniform number.

#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// Chooses by a cumulative table, so that stratified numbers make stratified choices. All probabilities are whole
/// multiples of 2^-24, the step of the renderer's uniform numbers: each choice is made exactly as often as
/// probability() says, also among tens of thousands, and whatever has a weight, however small, has at least one step.
/// Immutable; thread-safe.
class DiscreteDistribution {
public:
    /// Most entries with a weight.
    static constexpr uint32_t kMost = 1u << 24;

    DiscreteDistribution() = default;
    /// Probabilities in proportion to the weights (>= 0, finite), to within two steps. With `least`, as long: entry i
    /// has probability least[i] or more, and what their sum (rounded up to whole steps at most 1) leaves goes by the
    /// weights. Throws ErrorCode::Unsupported when there are not steps enough for all.
    explicit DiscreteDistribution(std::span<const double> weights, std::span<const double> least = {});

    /// No entry has a weight: nothing can be chosen.
    bool empty() const { return cdf_.empty(); }
    /// The entry for u in [0, 1); not when empty.
    uint32_t sample(float u) const;
    float probability(uint32_t entry) const { return empty() ? 0.0f : cdf_[entry + 1] - cdf_[entry]; }

    // The tables it draws by, for the device's copy (light_tables.h).
    std::span<const float> cdf() const { return cdf_; }         // entries + 1
    std::span<const uint32_t> guide() const { return guide_; }  // entry that holds i / (size - 1)

    uint64_t bytes() const;
    static uint64_t bytes_for(uint64_t entries);

private:
    std::vector<float> cdf_;
    std::vector<uint32_t> guide_;  // the guide table of [Chen and Asau 1974]
};

}  // namespace photond

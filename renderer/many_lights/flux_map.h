#pragma once
// Choice among the texels of a square map in proportion to what each is worth, such that well distributed points of
// the unit square choose well distributed texels: from the top of a pyramid of sums, each level divides the points
// among rows, then columns, and stretches them again.
//
// [Clarberg, Jarosz, Akenine-Möller, Jensen 2005] Wavelet Importance Sampling. ACM TOG 24(3), sec. 4.
//
// Texels lie along a Hilbert curve through the map (core/hilbert.h), so that a run of any length is one patch of it and
// the four texels below a sum lie side by side in memory.

#include <span>
#include <vector>

#include "renderer/many_lights/flux_map_shared.h"

namespace photond {

struct Texel {
    uint32_t index;     // along the curve
    float probability;  // with which a uniform point chooses it: exact but for the rounding of its factors
};

/// The sums of 4^k texels and how points are led down by them. GLSL twin: flux_map.glsl.
class FluxMap {
public:
    /// A side of 2^levels, up to 2^FLUX_MAP_MOST_LEVELS; nothing is worth anything yet.
    explicit FluxMap(uint32_t levels);

    uint32_t levels() const { return levels_; }
    uint32_t texels() const { return 1u << 2 * levels_; }
    /// Along the curve. What is no number, infinite or negative counts as 0, and 1e30 is the most that counts.
    std::span<float> worth() { return std::span(sums_).first(texels()); }
    std::span<const float> worth() const { return std::span(sums_).first(texels()); }
    /// Adds up the texels' worth; to be called after any change of it.
    void sum();

    float total() const { return sums_.back(); }  // 0: there is nothing to be chosen
    /// The texel that a point of the unit square (in fractions of 2^32) chooses; not to be called where the total is 0.
    /// Texels worth nothing are never chosen, all others have a chance.
    Texel choose(uvec2 point) const;

    uint64_t bytes() const { return sums_.capacity() * sizeof(float); }
    /// Texels and sums.
    static constexpr uint64_t values(uint32_t levels) {
        const uint64_t side = uint64_t{1} << levels;
        return (4 * side * side - 1) / 3;
    }

private:
    uint32_t levels_;
    std::vector<float> sums_;  // the texels, then level above level; the last is the total
};

/// Point i of the Halton sequence in bases 2 and 3, rotated [Cranley and Patterson 1976], in fractions of 2^32.
/// [Halton 1964] Radical-inverse quasi-random point sequence. CACM 7(12).
uvec2 rotated_halton_point(uint32_t i, const uvec2& rotation);

}  // namespace photond

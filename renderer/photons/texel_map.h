#pragma once
// One square map that all lights share: each sees the scene through a run of its texels, and what a texel sees reflects
// the texel's share of the light's flux. [Dachsbacher and Stamminger 2005]
//
// As in reflective_shadow_map.h a texel is a part of the numbers that EmissionSampler draws the light's directions by
// (places, for directional lights), jittered anew in every pass: all kinds of lights have a map. Here texels lie along
// a Hilbert curve through the map, and a light's j-th of n has the part [j/n, (j+1)/n) of the same curve through the
// light's square of numbers [He and Owen 2016]: areas are equal for any n, neighbours stay neighbours, and a light that
// has the whole map has the square itself in it.
//
// [Dachsbacher and Stamminger 2005] Reflective Shadow Maps. I3D.
// [He and Owen 2016] Extensible Grids: Uniform Sampling on a Space Filling Curve. JRSS B 78(4).

#include <vector>

#include "renderer/photons/texel_map_shared.h"
#include "renderer/transport/emission_sampling.h"

namespace photond {

/// Whose the texels are, the same in every pass. Borrows the emission.
class TexelMap {
public:
    /// `side`: a power of two up to 1024. The side^2 texels are divided among the lights by power.
    TexelMap(const EmissionSampler& emission, uint32_t side);

    uint32_t levels() const { return levels_; }
    uint32_t texels() const { return 1u << 2 * levels_; }
    const EmissionSampler& emission() const { return emission_; }
    /// The lights that have texels in every pass, by their first texels.
    const std::vector<gpu::TexelRun>& runs() const { return runs_; }
    /// The lights that would have less than one texel: each has one, in that share of the passes.
    const std::vector<gpu::TexelRun>& weak() const { return weak_; }

    uint64_t bytes() const { return (runs_.capacity() + weak_.capacity()) * sizeof(gpu::TexelRun); }
    static uint64_t bytes_for(uint64_t lights) { return 3 * lights * sizeof(gpu::TexelRun); }

private:
    const EmissionSampler& emission_;
    uint32_t levels_;
    std::vector<gpu::TexelRun> runs_, weak_;
};

/// The texels of one pass: a pure function of (seed, pass). Borrows the map.
class TexelMapPass {
public:
    TexelMapPass(const TexelMap& map, uint64_t seed, uint32_t pass);

    /// How many texels belong to a light; they are numbered from 0 on.
    uint32_t texels() const { return texels_; }
    /// The seed of the pass's random numbers. Each pass has its own, as the same texels come in each.
    uint64_t seed() const { return seed_; }
    /// Rotates points of the unit square, in fractions of 2^32.
    const uvec2& rotation() const { return rotation_; }
    /// The weak lights that have a texel in this pass; their texels follow those of the map's own runs.
    const std::vector<gpu::TexelRun>& chosen() const { return chosen_; }

    /// A light of its own, whose choice has that probability, and the numbers that sample_light() is to have of it.
    struct TexelNumbers {
        uint32_t light;
        float expected;
        vec2 u_position, u_direction;
    };
    TexelNumbers numbers(uint32_t texel, const vec2& u_jitter, vec2 u_position, vec2 u_direction) const;
    /// Where the path through a texel starts; its power is the texel's own, to be divided by nothing. `u_jitter`: where
    /// in the texel. It takes the place of one of the other two pairs of numbers, which are as EmissionSampler's. False
    /// when it carries nothing.
    bool sample(uint32_t texel, const vec2& u_jitter, const vec2& u_position, const vec2& u_direction,
                EmissionSample& out) const;

    /// The light's texels in this pass; null where it has none.
    const gpu::TexelRun* run_of(uint32_t light) const;
    /// How far along the whole map's curve a path with these numbers is, of a light that run_of() knows: its texel, and
    /// in the low 44 bits how far through that.
    uint64_t curve_place(const gpu::TexelRun& run, const vec2& u_position, const vec2& u_direction) const;
    static constexpr uint32_t kPlaceBits = 44;

private:
    const TexelMap& map_;
    std::vector<gpu::TexelRun> chosen_;
    uint32_t texels_;
    uint64_t seed_;
    uvec2 rotation_;
};

/// The place in the unit square that texel `j` of `n` (up to 2^20) has at `u_jitter`.
vec2 place_in_square(uint32_t j, uint32_t n, const vec2& u_jitter);
/// The texel of n whose part of the square holds that place.
uint32_t texel_at_place(const vec2& place, uint32_t n);

}  // namespace photond

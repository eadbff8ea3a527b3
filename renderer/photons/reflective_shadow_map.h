#pragma once
// Reflective shadow maps: each light sees the scene through a grid of texels, and what a texel sees reflects the
// texel's share of the light's flux. [Dachsbacher and Stamminger 2005]
//
// Here a texel is a cell of the numbers that EmissionSampler draws the light's directions by (places, for directional
// lights), jittered anew in every pass and traced: all kinds of lights have a map, all texels of a light carry about
// the same flux, and their sum has the right mean.
//
// [Dachsbacher and Stamminger 2005] Reflective Shadow Maps. I3D.

#include <vector>

#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// The grids of all lights, the same in every pass. Borrows the emission.
class ReflectiveShadowMaps {
public:
    /// About `texels` of them, at most one more, divided among the lights by power.
    ReflectiveShadowMaps(const EmissionSampler& emission, uint32_t texels);

    /// A light's texels, row after row.
    struct Grid {
        uint32_t light;
        uvec2 size;            // columns, rows
        uint64_t first_texel;  // of all lights'
        float expected;        // texels that the light's flux is divided by
    };

    uint64_t bytes() const { return (grids_.capacity() + weak_.capacity()) * sizeof(Grid); }

private:
    friend class ReflectiveShadowMapPass;

    const EmissionSampler& emission_;
    std::vector<Grid> grids_;  // first_texel rising
    std::vector<Grid> weak_;   // lights that would have less than one texel: one, in as many of the passes
    uint64_t texels_ = 0;      // of grids_
};

/// The texels of one pass: a pure function of (seed, pass). Borrows the maps.
class ReflectiveShadowMapPass {
public:
    ReflectiveShadowMapPass(const ReflectiveShadowMaps& maps, uint64_t seed, uint32_t pass);

    uint64_t texels() const { return texels_; }
    /// The seed of the pass's random numbers. Each pass has its own, as the same texels come in each.
    uint64_t seed() const { return seed_; }
    /// For the twin in reflected_photons.comp: all grids, by their first texels.
    std::vector<gpu::TexelGrid> device_grids() const;

    /// Where the path through a texel starts; its power is the texel's own, to be divided by nothing. `u_jitter`: where
    /// in the texel. It takes the place of one of the other two pairs of numbers, which are as EmissionSampler's. False
    /// when it carries nothing.
    bool sample(uint64_t texel, const vec2& u_jitter, vec2 u_position, vec2 u_direction, EmissionSample& out) const;

private:
    using Grid = ReflectiveShadowMaps::Grid;

    const ReflectiveShadowMaps& maps_;
    std::vector<Grid> chosen_;  // of the weak lights, after all others
    uint64_t texels_;
    uint64_t seed_;
};

}  // namespace photond

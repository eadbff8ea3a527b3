#pragma once
// Shadow photons: where a light is seen whole and where not at all, so that direct light needs shadow rays only near
// the borders between. Every photon a light sends is followed straight on through the scene: where it lands first the
// light is seen, at every further surface it faces there is shadow.
//
// A saving bought with an error: a shadow smaller than the photons about it can be missed.
//
// [Jensen and Christensen 1995] Efficiently Rendering Shadows using the Photon Map. Compugraphics.

#include "renderer/core/cancel.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/photons/hash_grid.h"
#include "renderer/scene/intersector.h"
#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/light_seen.h"

namespace photond {

/// Immutable and thread-safe once built. A source is what casts one shadow: all emitting triangles of an instance, one
/// punctual light, the environment (EmissionSample::source, LightSample::source).
class ShadowPhotons {
public:
    /// Follows `photons` light paths of that pass (a pure function of scene, seed and pass), in parallel.
    ShadowPhotons(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission, uint32_t photons,
                  float radius_m, uint64_t seed, uint32_t pass, const CancelToken& cancel, Counts& counts);

    /// What the photons about a point say of one light source: Unknown near a border, and where they are too few.
    /// `normal`: geometric, on the side looked at. Photons within radius_m whose normal makes at most 60 degrees with
    /// it are asked.
    LightSeen seen(const vec3& position, const vec3& normal, uint32_t source, Neighbours& scratch) const;

    uint64_t bytes() const;
    /// `photons` landed, lit and in shadow together.
    static uint64_t bytes_for(uint64_t photons);

    /// What is kept of one photon besides its place.
    struct Mark {
        uint32_t normal;          // Octahedral<16>, on the side it arrived at
        uint32_t source_and_lit;  // source << 1 | 1 where it landed first
    };

private:
    HashGrid grid_;
    std::vector<Mark> marks_;  // in the grid's order
};

}  // namespace photond

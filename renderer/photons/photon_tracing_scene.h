#pragma once
// What all batches of light paths of one tracer share, and the names of the numbers they are drawn by.

#include <vector>

#include "renderer/photons/photon_tracer.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/medium_stack.h"

namespace photond {

/// What all batches of a tracer share: prepared once, read by all threads.
struct PhotonTracingScene {
    /// How the hits of an instance are shaded.
    struct Shading {
        bool lambert;  // in lanes
        /// stores_photons(): the light that arrived where a texture is black counts in the estimate beside it.
        bool stores;
        LambertSurface surface;
    };

    /// First hits are found by `first`, all others by `later`.
    PhotonTracingScene(const Scene& scene, const Intersector& first, const Intersector& later,
                       const EmissionSampler& emission, const PhotonTracing& tracing);
    PhotonTracingScene(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                       const PhotonTracing& tracing)
        : PhotonTracingScene(scene, intersector, intersector, emission, tracing) {}

    const Scene& scene;
    const Intersector& intersector;
    const Intersector& later_intersector;
    const EmissionSampler& emission;
    const PhotonTracing tracing;
    const Absorption absorption;
    std::vector<Shading> shading;  // by instance
};

/// Whether photons are stored wherever they arrive on that instance, also where a texture is black: where some place of
/// it may scatter diffusely, by its colour.
bool stores_photons(const Scene& scene, uint32_t instance);

/// Two-dimensional sets of random numbers: three for the emission, then two for each scattering. The first ones, which
/// are distributed best (sobol.h), go where most of the variance comes from.
enum class EmissionSet : uint32_t { Direction, Position, Light };
enum class ScatteringSet : uint32_t { Direction, RouletteAndLobe };
constexpr uint32_t sample_set(EmissionSet set) {
    constexpr uint32_t kSets[] = {0, 1, 3};
    return kSets[static_cast<uint32_t>(set)];
}
/// Beyond those of all paths, where numbers are independent: jitter that followed a sequence would repeat from row to
/// row.
inline constexpr uint32_t kJitterSet = 1u << 31;
/// `scattering` counts from 1.
constexpr uint32_t sample_set(uint32_t scattering, ScatteringSet set) {
    if (scattering == 1) return set == ScatteringSet::Direction ? 2 : 4;
    return 2 * scattering + 1 + static_cast<uint32_t>(set);
}

}  // namespace photond

#pragma once
// What is known of a render before its first pass: a pilot traces some photons of its own random numbers, and says by
// them how large splats and beams should be where. It is a pure function of (scene, parameters, seed), and no pass sees
// another.

#include "renderer/methods/photon_splatting/beam_sizes.h"
#include "renderer/methods/photon_splatting/splat_sizes.h"

namespace photond {

struct PilotSizes {
    SplatSizes splats;
    BeamSizes beams;
};

/// Sizes for a render of that seed, whose photons are traced as `tracing` says: by a pilot where photons connect and
/// `adaptive_size` asks for it, else as splat_size says, and then stats.skipped tells of beams that are wider than what
/// casts them. Adds to stats.counts.photon_rays.
PilotSizes sizes_by_pilot(const SplatSettings& settings, const PhotonSplattingParams& params, const Scene& scene,
                          const Intersector& intersector, const EmissionSampler& emission, const PhotonTracing& tracing,
                          uint64_t seed, Stats& stats);

}  // namespace photond

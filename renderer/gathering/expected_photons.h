#pragma once
// What photons a scene is expected to store, and what leads them: as far as that is known before anything is traced.

#include "renderer/frame/render_context.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/projection_map.h"

namespace photond {

constexpr PhotonYield::OfMap yield_of(const PhotonYield& yield, PhotonMapKind kind) {
    return kind == PhotonMapKind::Global ? yield.global : yield.caustic;
}
/// Photons that so many light paths will store, of which each stores `stored`.
inline uint64_t expected_photons(uint32_t paths, double stored) { return static_cast<uint64_t>(stored * paths) + 1; }

/// Of the projection map of that kind of photons at most, what its building takes for a while included. Few scenes lead
/// global photons: one whose yield nobody has measured is taken not to.
inline uint64_t estimate_guide_bytes(PhotonMapKind kind, const Workload& workload) {
    const std::optional<PhotonYield>& yield = workload.photon_yield;
    const bool led = kind == PhotonMapKind::Caustic || (yield && yield->global.guided != yield->global.unguided);
    return led ? ProjectionMap::estimate_bytes(workload.lights) : 0;
}

}  // namespace photond

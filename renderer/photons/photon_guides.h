#pragma once
// The projection maps of a job with photon maps: one for each kind of photons that such a map helps.

#include <array>
#include <optional>

#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/projection_map.h"

namespace photond {

/// By what photons start, stage `photon_emission`; none where the scene has no light.
void make_emission(const Scene& scene, std::optional<EmissionSampler>& emission, Stats& stats);

/// What photons of that kind are led to.
constexpr ProjectionTarget target_of(PhotonMapKind kind) {
    return kind == PhotonMapKind::Caustic ? ProjectionTarget::SpecularSurfaces : ProjectionTarget::Surfaces;
}

class PhotonGuides {
public:
    /// Traces the pilot of that kind's map and keeps the map where it helps; else why not stands among what was
    /// skipped. In the stage `photon_emission`. A pure function of scene and seed; `emission` is borrowed.
    void add(PhotonMapKind kind, const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
             float glossy_threshold, uint64_t seed, MemoryBudget& budget, Stats& stats);

    /// The one that helps; nullptr: photons of that kind start as the lights emit.
    const ProjectionMap* of(PhotonMapKind kind) const {
        const std::optional<ProjectionMap>& map = maps_[static_cast<size_t>(kind)];
        return map ? &*map : nullptr;
    }

private:
    std::array<std::optional<ProjectionMap>, 2> maps_;
};

}  // namespace photond

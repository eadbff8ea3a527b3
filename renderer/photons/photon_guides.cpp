#include "renderer/photons/photon_guides.h"

#include <algorithm>

#include "renderer/scene/scene.h"

namespace photond {

void make_emission(const Scene& scene, std::optional<EmissionSampler>& emission, Stats& stats) {
    emission.reset();
    if (scene.triangle_lights.empty() && scene.punctual_lights.empty() && !scene.environment) return;
    const StageTimer timer(stats, "photon_emission");
    emission.emplace(scene);
    if (!(emission->total_power_w() > 0)) emission.reset();
}

void PhotonGuides::add(PhotonMapKind kind, const Scene& scene, const Intersector& intersector,
                       const EmissionSampler& emission, float glossy_threshold, uint64_t seed, MemoryBudget& budget,
                       Stats& stats) {
    const StageTimer timer(stats, "photon_emission");
    ProjectionMap map(scene, intersector, emission, target_of(kind), glossy_threshold, seed);
    stats.counts.photon_rays += map.pilot_rays();
    const bool caustic = kind == PhotonMapKind::Caustic;
    const std::string structure = caustic ? "projection_map" : "global_projection_map";
    // What its building took beside it has been given back, but it was there.
    const uint64_t kept = map.helps() ? map.bytes() : 0;
    if (map.has_bins()) {
        const uint64_t most = ProjectionMap::estimate_bytes(emission.lights());
        budget.record(structure + "_build", most - std::min(most, kept));
    }
    if (!map.helps()) {
        stats.skipped.push_back({caustic ? "projection map" : "global projection map", map.text(), map.bytes()});
        return;
    }
    budget.record(structure, kept);
    maps_[static_cast<size_t>(kind)].emplace(std::move(map));
}

}  // namespace photond

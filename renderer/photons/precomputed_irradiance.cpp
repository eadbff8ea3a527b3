#include "renderer/photons/precomputed_irradiance.h"

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/photons/disc_coverage.h"

namespace photond {

PrecomputedIrradiance::PrecomputedIrradiance(const PhotonMap& map, const EstimateSettings& settings,
                                             uint32_t most_scatterings)
    : search_radius_m_(map.search().radius_m), most_scatterings_(most_scatterings) {
    // The map's order is one of space: every fourth of it are photons spread as all are.
    const size_t count = (map.size() + kEvery - 1) / kEvery;
    const auto photon = [](size_t i) { return static_cast<uint32_t>(i * kEvery); };
    std::vector<vec3> points(count);
    for (size_t i = 0; i < count; ++i) points[i] = map.position(photon(i));
    std::vector<uint32_t> order(count);
    tree_ = KdTree(points, order);

    found_.resize(count);
    normals_.resize(count);
    ThreadLocal<Neighbours> scratch;
    parallel_for(count, 64, [&](size_t i) {
        const uint32_t index = photon(order[i]);
        const vec3 normal = map.payload(index).normal();
        normals_[i] = Octahedral<16>::encode(normal);
        Neighbours& neighbours = scratch.local();
        found_[i].irradiance = estimate_irradiance(map, settings, map.position(index), normal, most_scatterings,
                                                   neighbours, disc_turn(vec2(map.position(index))));
        found_[i].radius_m = neighbours.radius_m;
    });
}

std::optional<PrecomputedIrradiance::Found> PrecomputedIrradiance::find(const vec3& position,
                                                                        const vec3& normal) const {
    const uint32_t nearest = tree_.find_one(position, search_radius_m_, [&](uint32_t index) {
        return glm::dot(Octahedral<16>::decode(normals_[index]), normal) >= kDiscCosine;
    });
    if (nearest == tree_.size()) return std::nullopt;
    return found_[nearest];
}

uint64_t PrecomputedIrradiance::bytes() const {
    return tree_.bytes() + found_.capacity() * sizeof(Found) + normals_.capacity() * sizeof(uint32_t);
}

uint64_t PrecomputedIrradiance::bytes_for(uint64_t photons_in_map) {
    const uint64_t count = (photons_in_map + kEvery - 1) / kEvery;
    return KdTree::bytes_for(count) + count * (sizeof(Found) + sizeof(uint32_t));
}

}  // namespace photond

#include "renderer/photons/precomputed_irradiance.h"

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/photons/disc_coverage.h"

namespace photond {

namespace {

/// Of so many photons hardly ever more are marked: six standard deviations of their number above its mean.
uint64_t expected_marks(uint64_t photons) {
    const double mean = static_cast<double>(photons) / PHOTONS_A_MARK;
    return static_cast<uint64_t>(mean + 6 * std::sqrt(mean)) + 1;
}

}  // namespace

PrecomputedIrradiance::PrecomputedIrradiance(const PhotonMap& map, const EstimateSettings& settings,
                                             uint32_t most_scatterings)
    : settings_(settings), search_radius_m_(map.search().radius_m), most_scatterings_(most_scatterings) {
    std::vector<uint32_t> photons;
    photons.reserve(expected_marks(map.size()));
    for (uint32_t i = 0; i < map.size(); ++i)
        if (map.payload(i).marked()) photons.push_back(i);
    const size_t count = photons.size();
    std::vector<vec3> points(count);
    for (size_t i = 0; i < count; ++i) points[i] = map.position(photons[i]);
    std::vector<uint32_t> order(count);
    tree_ = KdTree(points, order);

    found_.resize(count);
    normals_.resize(count);
    ThreadLocal<Neighbours> scratch;
    parallel_for(count, 64, [&](size_t i) {
        const uint32_t index = photons[order[i]];
        const vec3 normal = map.payload(index).normal();
        normals_[i] = Octahedral<16>::encode(normal);
        Neighbours& neighbours = scratch.local();
        // Directions are rounded to a code, so that nearly all photons have the same number on all devices.
        const DiscQuery query{.turn = hash32(map.payload(index).direction)};
        found_[i].irradiance =
            estimate_irradiance(map, settings, map.position(index), normal, most_scatterings, neighbours, query);
        found_[i].radius_m = neighbours.radius_m;
    });
}

PrecomputedIrradiance::Lookup PrecomputedIrradiance::find(const vec3& position, const vec3& normal) const {
    std::optional<PlaceProbe> probe;
    if (settings_.coverage) probe.emplace(*settings_.coverage, position, normal, search_radius_m_);
    Lookup lookup{.found = std::nullopt, .is_dark = true};
    const uint32_t nearest = tree_.find_one(position, search_radius_m_, [&](uint32_t index) {
        if (glm::dot(Octahedral<16>::decode(normals_[index]), normal) < kDiscCosine) return false;
        lookup.is_dark = false;
        const vec3 photon = tree_.position(index), to = photon - position;
        const float radius_m = found_[index].radius_m;
        return glm::dot(to, to) <= sqr(radius_m) &&
               std::fabs(glm::dot(to, normal)) <= disc_thickness_m(settings_, radius_m) &&
               (!probe || probe->sees(photon));
    });
    if (nearest < tree_.size()) lookup.found = found_[nearest];
    return lookup;
}

uint64_t PrecomputedIrradiance::bytes() const {
    return tree_.bytes() + found_.capacity() * sizeof(Found) + normals_.capacity() * sizeof(uint32_t);
}

uint64_t PrecomputedIrradiance::bytes_for(uint64_t photons_in_map) {
    const uint64_t count = expected_marks(photons_in_map);
    return KdTree::bytes_for(count) + count * (sizeof(Found) + sizeof(uint32_t));
}

}  // namespace photond

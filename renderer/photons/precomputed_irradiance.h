#pragma once
// Irradiance worked out beforehand at some of the photons, so that a gather ray's end costs one search for one photon.
//
// [Christensen 1999] Faster Photon Map Global Illumination. Journal of Graphics Tools 4(3).

#include <optional>

#include "renderer/core/memory_budget.h"
#include "renderer/photons/photon_map.h"
#include "renderer/photons/radiance_estimate.h"

namespace photond {

/// Immutable and thread-safe once built; keeps nothing of the map it was built from.
class PrecomputedIrradiance {
public:
    /// One photon in this many gets an irradiance: Christensen found no difference to be seen with every fourth.
    static constexpr uint32_t kEvery = 4;

    /// Estimates the irradiance, by photons of at most `most_scatterings`, at every kEvery-th photon of the map, on the
    /// side it arrived at. In parallel.
    PrecomputedIrradiance(const PhotonMap& map, const EstimateSettings& settings, uint32_t most_scatterings);

    uint32_t most_scatterings() const { return most_scatterings_; }
    size_t size() const { return found_.size(); }

    struct Found {
        Rgb irradiance;      // [W m^-2]
        float radius_m = 0;  // of the disc it was estimated on
    };
    /// What is known at the nearest of those photons whose normal makes at most 60 degrees with `normal` (unit,
    /// geometric) and which lies within the map's search radius. None: nothing arrives there.
    std::optional<Found> find(const vec3& position, const vec3& normal) const;

    uint64_t bytes() const;
    static uint64_t bytes_for(uint64_t photons_in_map);

private:
    KdTree tree_;
    std::vector<Found> found_;       // in the tree's order
    std::vector<uint32_t> normals_;  // Octahedral<16>
    float search_radius_m_ = 0;
    uint32_t most_scatterings_ = 0;
};

}  // namespace photond

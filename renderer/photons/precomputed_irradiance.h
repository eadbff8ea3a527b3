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
///
/// The photon whose disc it is counts on it. In even light a place's nearest photon lies at the rim of an emptiness,
/// the disc within which none of the marked photons is, and what that lacks is one photon in the mean. Without the
/// photon itself the k nearest of 50 are 2 % too few.
class PrecomputedIrradiance {
public:
    /// Estimates the irradiance, by photons of at most `most_scatterings`, at the marked photons of the map, on the
    /// side they arrived at. In parallel. What `settings` borrows is borrowed for find() as well.
    PrecomputedIrradiance(const PhotonMap& map, const EstimateSettings& settings, uint32_t most_scatterings);

    uint32_t most_scatterings() const { return most_scatterings_; }
    size_t size() const { return found_.size(); }

    struct Found {
        Rgb irradiance;      // [W m^-2]
        float radius_m = 0;  // of the disc it was estimated on
    };
    /// What is known of a place.
    struct Lookup {
        std::optional<Found> found;
        bool is_dark = false;  // no marked photon at all faces its way within the search radius
    };
    /// What is known at the nearest of those photons that stands for the place: it is no farther away than its disc's
    /// radius, no farther from the tangent plane than photons of its disc may be, its normal makes at most 60 degrees
    /// with `normal` (unit, geometric), and where discs are clipped no wall stands between (PlaceProbe). Nothing is
    /// found where no photon does, and a disc of the place's own is to be asked.
    Lookup find(const vec3& position, const vec3& normal) const;

    uint64_t bytes() const;
    static uint64_t bytes_for(uint64_t photons_in_map);

private:
    EstimateSettings settings_;
    KdTree tree_;
    std::vector<Found> found_;       // in the tree's order
    std::vector<uint32_t> normals_;  // Octahedral<16>
    float search_radius_m_ = 0;
    uint32_t most_scatterings_ = 0;
};

}  // namespace photond

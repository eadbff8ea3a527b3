#pragma once
// The photons of a map as they stream past points: in the order of a grid's cells, what is asked of all of them close
// together, each with the radius of its own disc.
//
// Photons of like radius are sorted into one grid (a few octaves of radii), so that cells fit the discs in them.

#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/methods/reverse_photon_mapping/params.h"
#include "renderer/photons/radiance_estimate.h"

namespace photond {

/// What is asked of each photon near a group of points.
struct alignas(32) StreamedPhoton {
    vec3 position;
    float radius_sq_m2;        // of its disc
    Rgb power_over_area;       // [W m^-2], over the disc's radius squared: times K r^2 it is irradiance
    uint32_t normal_and_path;  // PhotonPayload's
};
/// What is asked of few.
struct alignas(32) StreamedDirection {
    vec3 wi;       // towards where the light came from
    float cosine;  // to the normal
    vec3 normal;
    float thickness_m;  // how far from a point's tangent plane it counts
};
static_assert(sizeof(StreamedPhoton) == 32 && sizeof(StreamedDirection) == 32);

class PhotonStream {
public:
    /// Photons whose discs are of like size.
    struct Octave {
        float radius_m = 0;                                 // no disc is larger
        float least_thickness_m = 0, most_thickness_m = 0;  // of discs
        const HashGrid* grid = nullptr;                     // of the photons' positions, in their order
        std::vector<StreamedPhoton> photons;
        std::vector<StreamedDirection> directions;  // theirs

        void set(size_t photon, const PhotonMap& map, uint32_t index, float radius_m, const EstimateSettings& settings);
    };

    PhotonStream() = default;
    /// The map is borrowed, and lives as long. `radii_m`: of its photons; empty: all have the map's own. In parallel.
    PhotonStream(const PhotonMap& map, const EstimateSettings& settings, std::vector<float> radii_m);

    bool empty() const { return octaves_.empty(); }
    const PhotonMap& map() const { return *map_; }
    std::span<const Octave> octaves() const { return octaves_; }
    /// The median of the photons' radii: the size of cells of points that suits them.
    float typical_radius_m() const { return typical_radius_m_; }
    bool has_one_radius() const { return radii_m_.empty(); }
    /// Radius of the discs at a place: that of the nearest photon; `most_m` where none is so near.
    float radius_at_m(const vec3& place, float most_m) const;

    uint64_t bytes() const;
    static uint64_t bytes_for(uint64_t photons, InfluenceRadius influence);

private:
    const PhotonMap* map_ = nullptr;
    std::vector<float> radii_m_;  // by the map's index
    float typical_radius_m_ = 0;
    std::vector<HashGrid> grids_;  // of octaves, where the map's own does not do
    std::vector<Octave> octaves_;
};

/// Radius of each photon's disc; empty for InfluenceRadius::Fixed. `nearest`: k. None is larger than the map's own. In
/// parallel.
std::vector<float> influence_radii_m(const PhotonMap& map, InfluenceRadius influence, uint32_t nearest);

}  // namespace photond

#pragma once
// How large splats are where. Connections have the exact mean for any radius at a receiver, so the radius may follow
// the light: small where many photons pass by, large where few do, so that all visible points get alike numbers of
// splats. The relative error of the image is then as even as that of the k nearest photons, without their bias.
//
// The density of photons in space comes from a pilot (splat_pilot.h), whose rays leave their length in the cells of a
// coarse grid.

#include <optional>
#include <span>
#include <vector>

#include "renderer/photons/photon_tracer.h"

namespace photond {

class SplatSizes {
public:
    /// The same radius everywhere.
    explicit SplatSizes(float radius_m) : radius_m_(radius_m) {}

    /// From a pilot's photons, whose rays are followed to their ends. Adds to counts.photon_rays.
    SplatSizes(float radius_m, const Bounds3& bounds, const TracedReflections& pilot, const Intersector& intersector,
               Counts& counts);

    /// Radius [m] of the splats that light points about p, a surface whose unit normal is n there: that of the
    /// constructor where light is as dense as it is on average, and from a third to three times that.
    float radius_m(const vec3& p, const vec3& n) const;

    /// For the twin in splat_clusters.comp; none: the same radius everywhere. Borrows the factors.
    struct Grid {
        vec3 low;
        float cell_m;
        uvec3 cells;
        std::span<const float> factors;  // on the radius, x fastest
    };
    std::optional<Grid> grid() const {
        if (factors_.empty()) return std::nullopt;
        return Grid{low_, cell_m_, cells_, factors_};
    }

    uint64_t bytes() const { return factors_.capacity() * sizeof(float); }

private:
    static constexpr uint32_t kCells = 24;  // along the longest side

    uvec3 cell(const vec3& p) const;
    size_t index(const uvec3& cell) const { return (size_t{cell.z} * cells_.y + cell.y) * cells_.x + cell.x; }

    float radius_m_;
    vec3 low_{0};
    float cell_m_ = 1;
    uvec3 cells_{0};
    std::vector<float> factors_;  // on the radius, a cell; empty: 1
};

}  // namespace photond

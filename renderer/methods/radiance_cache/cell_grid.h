#pragma once
// Which cell of a hash grid a place of a surface lies in, as an eye that far off and a ray that long look at it.
//
// Cells are cubes whose sides halve from level to level. A cell's side is at most a share of the distance to the eye,
// and at most what the ray to it is spread over: a ray shorter than the cell it ends in would look at the surface it
// left, and at what lies beyond the corner, as one. [Binder et al. 2018] Fast Path Space Filtering by Jittered Spatial
// Hashing; [Gautron 2020] Real-Time Ray-Traced Ambient Occlusion of Complex Scenes using Spatial Hashing.

#include <optional>

#include "renderer/core/geometry.h"

namespace photond {

/// A cell's name: the bucket that it belongs to follows from `place`, and within one it is told by `fingerprint`, which
/// is not 0. That two cells of a scene have the same is as good as impossible: with 1e6 cells in buckets of 8, some
/// 2e-3 of them are expected to be taken for another.
struct CellKey {
    uint32_t place;
    uint32_t fingerprint;
};

struct CellGrid {
    vec3 eye{0};           // world [m]
    vec3 origin{0};        // of the grid, drawn anew for each cache, so that faces of cells do not stay where they are
    float coarsest_m = 1;  // side of cells of level 0
    float of_distance = 0.1f;  // side over the distance to the eye, at most

    /// Levels that are finer than what the distance to the eye asks for, at most: rays yet shorter find no cell.
    static constexpr uint32_t kFinerLevels = 3;
    static constexpr uint32_t kMostLevel = 20;
    /// Levels that are coarser, at most, which are filled as well, and asked where the finer ones know too little.
    static constexpr uint32_t kCoarserLevels = 3;

    float side_m(uint32_t level) const { return coarsest_m / static_cast<float>(1u << level); }
    /// The level of a place that far from the eye, met by a ray spread over `spread_m` (ray_spread_m()); empty where
    /// that is too little.
    std::optional<uint32_t> level(float distance_m, float spread_m) const;
    /// The cell that a place, world [m], lies in. `normal`: unit, on the side that is looked at, so that the sides of a
    /// thin wall are apart; `directions`: of the directions that a cell is divided into, direction_bin().
    CellKey key(const vec3& position, const vec3& normal, uint32_t direction, uint32_t level) const;
};

/// Over what a ray is spread that went `distance_m` in a direction drawn with that density [1/sr], as wide as a diffuse
/// reflector's straight ahead after as many metres; 0 for delta lobes' infinite densities. Those of a path add up.
/// [Bekaert et al. 2003] A Custom Designed Density Estimator for Light Transport.
inline float ray_spread_m(float distance_m, float pdf_sa) { return distance_m / std::sqrt(kPi * pdf_sa); }

/// Which of side x side parts of the sphere a unit direction lies in, by an octahedron's faces.
uint32_t direction_bin(const vec3& direction, uint32_t side);

}  // namespace photond

#pragma once
// Where voxels lie, and how world positions become whole numbers of 1/256 voxel.
//
// A position is rounded by single-precision operations in one order, none fused, so that the device (voxel_grid.glsl)
// gets the same integers. Of an instance with a transform the world position is made here too, by the same rule: not as
// world_triangle() makes it, from which it may differ by the rounding of its coordinates.

#include <array>

#include "renderer/core/geometry.h"
#include "renderer/scene/material.h"
#include "renderer/voxels/svo_shared.h"

namespace photond {

struct Scene;

using gpu::VoxelGrid;

/// About the bounds, a voxel's width away from them or more. `resolution`: a power of two, 16 to 1024; throws
/// ErrorCode::OutOfRange for others. Bounds of no extent, or none at all, get a grid all the same.
VoxelGrid make_voxel_grid(const Bounds3& bounds, uint32_t resolution);
inline bool same_grid(const VoxelGrid& a, const VoxelGrid& b) {
    return a.low == b.low && a.cell_m == b.cell_m && a.resolution == b.resolution;
}

/// The least edge [m] of cells about the bounds whose places floats tell apart.
double least_cell_m(const Bounds3& bounds);

/// Of a grid, for the arrays of a tree; what else it holds is 0.
gpu::SvoConstants svo_constants_of(const VoxelGrid& grid);

/// Position in 1/256 voxel from the grid's least corner, rounded to the nearest: off by 0.55 at most, of a position in
/// the grid. Positions far outside are cut off at +-2^19.
glm::ivec3 quantise(const gpu::SvoConstants& constants, const vec3& position);

/// A triangle's corners so.
struct QuantisedTriangle {
    std::array<glm::ivec3, 3> p;
};
QuantisedTriangle quantised_triangle(const gpu::SvoConstants& constants, const Scene& scene, uint32_t instance,
                                     uint32_t triangle);

/// Whether a material's triangles are voxelised: those that shadow rays may be stopped by. Glass stops them, and so do
/// masked and blended surfaces, whose texture is not asked: foliage is whole, which darkens what lies behind it. Where
/// the material's own factor says that more than half of the light passes (blended, alpha below 1/2; masked, alpha
/// below the cutoff), the surface is left out.
bool is_voxelised(const Material& material);

/// Where each instance's triangles begin in one numbering of all: instance_count + 1 numbers. Throws
/// ErrorCode::OutOfMemory past 2^32 - 2 triangles.
std::vector<uint32_t> first_triangles_of(const Scene& scene);

}  // namespace photond

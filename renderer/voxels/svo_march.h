#pragma once
// Segments and rays against the set voxels of a tree. GLSL twin: svo_march.glsl.
//
// SVO-restart (thesis, Fig. 3.3) down to the bricks, then voxel by voxel through their bits. Departure: where a ray
// goes on is kept as the whole-numbered voxel it is in, which moves on by one at least along the axis it leaves a box
// by and never back, so that no epsilon is needed, no voxel on the way is missed, and no walk is longer than 3 *
// resolution steps, whatever the ray.

#include <span>

#include "renderer/voxels/svo_shared.h"

namespace photond {

/// The arrays of a tree; borrowed.
struct SvoView {
    gpu::SvoConstants constants;
    std::span<const gpu::SvoNode> nodes;
    std::span<const gpu::SvoBrick> bricks;
    std::span<const uint32_t> surfaces;  // empty: none

    bool is_set(const uvec3& voxel) const;
    /// The number of the triangle in the voxel that holds a point; ~0 where that is not set, or outside of the grid.
    /// The tree has surfaces.
    uint32_t surface_at(const vec3& position) const;
};

/// How far the ends of a segment are moved, in voxels; others than these are for measuring what they should be.
struct SvoOffsets {
    float normal = SVO_NORMAL_OFFSET;
    float pull_in = SVO_PULL_IN;
};

/// A point on a surface lifted off the voxels that the surface's plane is in: towards `normal`, unit.
vec3 svo_lift(const SvoView& tree, const vec3& position, const vec3& normal, float offset = SVO_NORMAL_OFFSET);

/// Whether the open segment between two points on surfaces meets a set voxel; false where what is left of it once its
/// ends are pulled in is nothing, and for positions that are no numbers.
bool svo_occluded(const SvoView& tree, const vec3& a, const vec3& b);
/// The same with unit normals of the sides that the segment leaves to: the ends are lifted off their own surfaces'
/// voxels first, which spares them however flat the segment lies.
bool svo_occluded(const SvoView& tree, const vec3& a, const vec3& normal_a, const vec3& b, const vec3& normal_b,
                  const SvoOffsets& offsets = SvoOffsets());

struct VoxelHit {
    float t = kInfinity;  // where the ray enters the voxel; 0 in the one it starts in
    uvec3 voxel{0};
    uint32_t surface = ~0u;  // the triangle's number; ~0: the tree has no surfaces
};
/// The first set voxel that the ray meets in [0, t_max); nothing is moved. False: none.
bool svo_first_voxel(const SvoView& tree, const Ray& ray, VoxelHit& hit);

}  // namespace photond

#pragma once
// Segments and rays against the set voxels of a tree. GLSL twin: svo_march.glsl.
//
// The device walks by SVO-restart (thesis, Fig. 3.3) down to the bricks, then voxel by voxel through their bits; the
// CPU, several rays at a time, by free cubes (svo_cells.h), past bricks none of whose set voxels is between where the
// ray enters and leaves them, and voxel by voxel through the others. Both answer alike but for rounding. Departure:
// where a ray goes on is kept as the whole-numbered voxel it is in, which moves on by one at least along the axis it
// leaves a box by and never back, so that no epsilon is needed, no voxel on the way is missed, and no walk is longer
// than 3 * resolution steps, whatever the ray.

#include <span>

#include "renderer/voxels/svo_cells.h"

namespace photond {

/// The arrays of a tree; borrowed.
struct SvoView {
    gpu::SvoConstants constants;
    std::span<const gpu::SvoNode> nodes;
    std::span<const gpu::SvoBrick> bricks;
    std::span<const uint32_t> surfaces;  // empty: none
    const SvoCells* cells = nullptr;     // null: not to be marched through

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

/// A segment with unit normals of the sides that it leaves to at its ends.
struct SvoSegment {
    vec3 a, normal_a, b, normal_b;
};
/// The same of many, several at a time; of as many answers. Voxels that a segment enters farther than `reach_m` from
/// its end a do not count.
void svo_occluded(const SvoView& tree, std::span<const SvoSegment> segments, std::span<uint8_t> occluded,
                  float reach_m = kInfinity);

struct VoxelHit {
    float t = kInfinity;  // where the ray enters the voxel; 0 in the one it starts in
    uvec3 voxel{0};
    uint32_t surface = ~0u;  // the triangle's number; ~0: the tree has no surfaces
};
/// The first set voxel that the ray meets in [0, t_max); nothing is moved. False: none, or a direction of 0.
bool svo_first_voxel(const SvoView& tree, const Ray& ray, VoxelHit& hit);

}  // namespace photond

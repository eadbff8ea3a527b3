// Voxels and the sparse voxel octree over them: for both compilers, scalar layout.
//
// [Sun 2015] Many-Light Real-Time Global Illumination using Sparse Voxel Octree, chapters 3 and 4. Thesis, Worcester
// Polytechnic Institute.
#ifndef PHOTOND_SVO_SHARED_H
#define PHOTOND_SVO_SHARED_H

// Sub-units along a voxel: positions are rounded to multiples of 1/256 voxel, and compared exactly from there on.
#define VOXEL_UNITS 256
#define VOXEL_WIDEN 1  // sub-units to either side of a box that a triangle is held against
#define VOXEL_LEAST_RESOLUTION 16
#define VOXEL_MOST_RESOLUTION 1024
#define BRICK_SIDE 4  // voxels; a brick's 64 are one mask of two words
#define SVO_MOST_LEVELS 8

// SvoNode::info
#define SVO_LEAF 0x80000000u
#define SVO_FLAGGED 0x40000000u
#define SVO_TILE_MASK 0x3fffffffu
#define SVO_NO_DATA 0xffffffffu

#define SVO_GROUP 64  // threads

// How far the ends of a segment are moved before it is held against the voxels, in voxels. Measured by `svo_bench
// errors`: light wrongly shadowed and light leaked, of the unshadowed sum of G, at 256^3 (128^3): interior 10.0 and 1.5
// % (13.4, 4.9), dragon and buddha 1.9 and 0.3 % (3.9, 0.6), Sponza 5.5 and 4.1 % (7.3, 5.3). Of a lift of 1: less
// leaves ends in their own plane's voxels (3/4: dragon and buddha 4.3 %), one above leaks. Longer pull-ins trade
// shadows for leaks one for one; sparing the unbroken run of set voxels at each end trades them no better.
//
// The lift is along the end's unit normal n, times |n.x| + |n.y| + |n.z|: its plane's voxels are no higher than 1 of
// that, and widened by 1/256. Pull-ins are along the segment, after that; the blind one where no normals are given.
#define SVO_NORMAL_OFFSET 1.01f
#define SVO_ON_PLANE 0.01f  // voxels beside a triangle's plane that rounding may leave a point
#define SVO_PULL_IN 1.5f
#define SVO_BLIND_PULL_IN 2.0f

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// A cube of voxels about a scene (voxel_grid.h makes it).
struct VoxelGrid {
    vec3 low;         // its least corner, world space
    float cell_m;     // a voxel's edge
    uint resolution;  // voxels along an edge: a power of two
};

/// 16 bytes, eight siblings a tile (thesis, Fig. 3.2). The root is not stored: tile 0 holds its children, which are of
/// level 1. Children are numbered x + 2 y + 4 z of the half they lie in. A flagged node of the last level is a brick;
/// its size is 4 voxels.
struct SvoNode {
    uint info;  // leaf, flagged, and the tile of its children where it is no leaf
    uint data;  // of a brick: its place among the bricks; else SVO_NO_DATA
    uint low;   // its first and last voxel: x + 2^10 y + 2^20 z
    uint high;
};

/// 4 x 4 x 4 voxels: bit x + 4 y + 16 z is set where a triangle touches the voxel; 32 bits a word.
struct SvoBrick {
    uint mask[2];
};

/// What shaders need to know of a tree besides its arrays.
///
/// `surfaces`, where a tree has them: word i < surface_base says for brick i where its voxels' triangles begin, counted
/// from surface_base; there the triangle numbers stand, one a set voxel in the order of their bits. Triangles are
/// numbered instance after instance, and `first_triangles` (instance_count + 1 words) says where each begins.
struct SvoConstants {
    VoxelGrid grid;
    float voxels_per_m;
    float units_per_m;  // VOXEL_UNITS * voxels_per_m
    uint levels;        // the bricks' level: log2(resolution) - 2
    uint surface_base;
    uint instance_count;
    uint triangle_count;
};

#ifdef __cplusplus
static_assert(sizeof(VoxelGrid) == 20 && sizeof(SvoNode) == 16 && sizeof(SvoBrick) == 8 && sizeof(SvoConstants) == 44);
}  // namespace photond::gpu
#endif

#endif

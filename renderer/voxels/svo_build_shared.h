// What the passes that build an octree on the device share: for both compilers, scalar layout.
#ifndef PHOTOND_SVO_BUILD_SHARED_H
#define PHOTOND_SVO_BUILD_SHARED_H

#include "renderer/voxels/svo_shared.h"

#define SVO_MOST_COLUMNS 0x80000000u

// Which nodes are flagged is kept as bits in Morton order, level after level from the root (level 0) on; each level
// begins with the word said here, 32 nodes a word.
#define SVO_FIRST_WORD(level) ((level) < 2u ? (level) : 2u + 2u * (((1u << (3u * (level)-6u)) - 1u) / 7u))

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// All zero before the first build; each build leaves it ready for the next.
struct SvoBuildState {
    uint columns;    // of bricks, of all triangles asked; 2^32 - 1: more than 32 bits hold
    uint fragments;  // that there would be, whatever there is room for; so the nodes and bricks
    uint nodes;
    uint bricks;
    uint voxels;        // of the fragments and bricks that there was room for
    uint ended_groups;  // of the pass under way (svo_sums.glsl)
    // What dispatch_indirect() reads: rows of groups, as CommandList::dispatch_threads() makes them.
    uint column_groups[3];
    uint fill_groups[3];
    uint brick_groups[3];
    uint surface_groups[3];
    uint kept_groups[3];
};

/// What is voxelised: instances, in rising order.
struct SvoAskedInstance {
    uint first;           // of its triangles, among those of the list
    uint instance;        // in the scene
    uint first_triangle;  // among all instances'
};

/// A triangle's voxels in one brick.
struct SvoFragment {
    uint brick;  // its Morton code: the children's numbers from the root down
    uint triangle;
    uint mask[2];
};

struct SvoBuildPush {
    uint levels;
    uint words;      // of the nodes' bits
    uint sum_group;  // elements that a group sums (svo_sums.glsl)
    uint fragment_capacity;
    uint node_capacity;
    uint brick_capacity;
    uint voxel_capacity;  // of surfaces
    uint surfaces;        // whether there are any
    uint asked;           // instances in the list
    uint asked_triangles;
    uint follows;  // whether the fragments add to a kept tree, whose bricks are in place
    uint kept_voxels;
    uint kept_bricks;
};

#ifdef __cplusplus
static_assert(sizeof(SvoBuildState) == 84 && sizeof(SvoAskedInstance) == 12 && sizeof(SvoFragment) == 16 &&
              sizeof(SvoBuildPush) == 52);
}  // namespace photond::gpu
#endif

#endif

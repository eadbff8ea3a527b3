// What the passes that build an octree on the device share: for both compilers, scalar layout.
#ifndef PHOTOND_SVO_BUILD_SHARED_H
#define PHOTOND_SVO_BUILD_SHARED_H

#include "renderer/voxels/svo_shared.h"

// Words of the build's state.
#define SVO_STATE_TRIANGLES 0
#define SVO_STATE_COLUMNS 1  // of bricks, of all triangles: modulo 2^32
#define SVO_STATE_COLUMNS_LOW 2
#define SVO_STATE_COLUMNS_HIGH 3
#define SVO_STATE_FRAGMENTS 4  // that there would be, whatever there is room for; so the numbers below
#define SVO_STATE_NODES 5
#define SVO_STATE_BRICKS 6
#define SVO_STATE_VOXELS 7
#define SVO_STATE_LEVEL_FIRST 8     // the first node of the level under way,
#define SVO_STATE_LEVEL_NODES 9     // its nodes there is room for,
#define SVO_STATE_LEVEL_FLAGGED 10  // and those of them that are flagged
#define SVO_STATE_WORDS 11

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// A triangle's voxels in one brick.
struct SvoFragment {
    uint brick;  // x + 2^8 y + 2^16 z
    uint triangle;
    uint mask[2];
};

struct SvoBuildPush {
    uint level;  // under way: 1 ... levels
    uint levels;
    uint resolution;
    uint fragment_capacity;
    uint node_capacity;
    uint brick_capacity;
    uint surface_base;
};

#ifdef __cplusplus
static_assert(sizeof(SvoFragment) == 16 && sizeof(SvoBuildPush) == 28);
}  // namespace photond::gpu
#endif

#endif

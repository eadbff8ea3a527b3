// A voxel octree with light in it, for both compilers (cone_tree_gpu.h).
#ifndef PHOTOND_CONE_TREE_SHARED_H
#define PHOTOND_CONE_TREE_SHARED_H

#include "renderer/voxels/svo_shared.h"

#define CONE_GROUP 64  // threads
#define NO_CONE_CELL 0xffffffffu

// The rays that tell how much of a voxel's side its surfaces cover, along either side of it.
#define COVER_RAYS_SIDE 3u
// A voxel begins that much of its edge before its side, so that a surface on the side is in one voxel and not in two.
#define VOXEL_SHIFT 1e-3f
#define OPACITY_BITS 10u  // an axis', of a cell's word
#define OPACITY_MOST 1023u

// Specialisation constants.
#define EVERY_CELL_ID 103
#define DRAWN_CONES_ID 104

#ifdef __cplusplus
namespace photond::gpu {
using glm::ivec3;
#endif

/// What is seen of a voxel, or of a cube of 2^n voxels along its edge. `light`: from before each of its six sides (x,
/// -x, y, ...), what comes from the square of a side, in the mean: radiance times opacity, three values that share an
/// exponent. `opacity`: how much of it along each axis stops light.
struct ConeCell {
    uint light[6];
    uint opacity;
};

/// Cells of all sizes in one array: voxels in the order of the tree's surfaces, eights of bricks, bricks, nodes.
struct ConeTreeConstants {
    uint levels;  // SvoConstants'
    uint first_half;
    uint first_brick;
    uint first_node;
    uint table_words;
    uint voxels;
};

/// Of cone_cover.comp: bricks, half open.
struct ConeCoverPush {
    uint first;
    uint end;
};
/// Of cone_filter.comp: the size of the cells made, as a power of two of voxels.
struct ConeFilterPush {
    uint mip;
};

/// How cones go.
struct ConeMarch {
    float aperture;  // a diffuse cone's width over its length
    float step;      // over its width
    float start;     // voxels off the surface
    float gloss;     // a specular cone's width over its length, over alpha
    float glossy_threshold;
    uint key;  // of the pass's random numbers
};

/// Of cone_light.comp.
struct ConeLightPush {
    ConeMarch march;
    uint first_point;  // half open
    uint end_point;
};

#ifdef __cplusplus
static_assert(sizeof(ConeCell) == 28 && sizeof(ConeTreeConstants) == 24 && sizeof(ConeLightPush) == 32,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif

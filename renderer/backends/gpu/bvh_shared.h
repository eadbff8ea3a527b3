// The ray structure's arrays as bvh_build.cpp writes and bvh.glsl reads them: eight-wide nodes whose boxes are
// quantised to a grid of their own. For both compilers; all numbers in the order and meaning of the paper, but for
// `scales`, whose bytes are the exponents of floats as they stand, and for slots, which are mirrored (bvh_build.cpp).
// [Ylitie, Karras, Laine 2017] Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs. HPG.
#ifndef PHOTOND_BVH_SHARED_H
#define PHOTOND_BVH_SHARED_H

// Most entries a traversal's stack may ever hold: levels of wide nodes, those within an instance included, and one more
// for an instance. build_bvh() refuses a scene that needs more.
#define BVH_STACK 32

// Specialisation constant: BvhData::two_levels.
#define BVH_TWO_LEVELS_ID 18

// BvhTriangle::kind
#define BVH_OPAQUE 0u
#define BVH_COVERED_IN_PART 1u  // masked or blended
#define BVH_INSTANCE 2u         // no triangle

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

// Child i of a node: meta byte 0: none; 001sssss: a node, sssss = 24 + i; otherwise triangles, one to three, their
// number in unary in the upper three bits and the first of them, from `triangles` on, in the lower five.
struct BvhNode {
    vec3 grid_origin;
    uint scales;     // x, y, z: exponent of the grid's spacing; uppermost byte: which children are nodes
    uint nodes;      // the first child that is a node; the others follow
    uint triangles;  // the first of all children's triangles
    uint meta[2];    // bytes, as the following
    uint low_x[2], low_y[2], low_z[2];
    uint high_x[2], high_y[2], high_z[2];
};

// Corners in the space of the tree it is in. In the place of a triangle of the top tree there may be an instance of a
// mesh: `triangle` is the root of that mesh's tree, `corners` begins with the place of its BvhTransform in this array
// (bits of a uint).
struct BvhTriangle {
    vec3 corners[3];
    uint kind;
    uint triangle;  // in its mesh
    uint instance;  // NO_HIT in the tree of a mesh
};

// World to instance.
struct BvhTransform {
    mat4x3 from_world;
};

#ifdef __cplusplus
static_assert(sizeof(BvhNode) == 80 && sizeof(BvhTriangle) == 48 && sizeof(BvhTransform) == 48);
}  // namespace photond::gpu
#endif

#endif

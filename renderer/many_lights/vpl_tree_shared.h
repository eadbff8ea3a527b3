// A tree over virtual point lights, for both compilers. C++: vpl_tree.h, GLSL: vpl_tree.glsl.
#ifndef PHOTOND_VPL_TREE_SHARED_H
#define PHOTOND_VPL_TREE_SHARED_H

#define VPL_TREE_GROUP 128        // threads; as many nodes of a level a group brings together
#define VPL_TREE_GROUP_LEVELS 7u  // what 128 nodes become one in
#define VPL_TREE_ROOT 1u          // nodes are numbered as in a heap: those below node i are 2 i and 2 i + 1
#define NO_VPL 0xffffffffu        // VplTreeNode::light of inner nodes, and of leaves past the last light

// Keys that lights are sorted by: along a Morton curve of position, and of the axis that the normal is nearest to
// after some of its levels.
#define VPL_KEY_AXIS_BITS 9u    // of position, each axis
#define VPL_KEY_COARSE_BITS 2u  // of those, before the normal
#define VPL_KEY_BITS 30u

// Words of the device's tree state: the lights' box, as ordered_bits().
#define VPL_TREE_LOW 0
#define VPL_TREE_HIGH 3
#define VPL_TREE_STATE_WORDS 6

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// Lights together. Where `intensity` is 0 there are none, and nothing else counts.
struct VplTreeNode {
    vec3 low;         // box of the positions
    float intensity;  // sum over the lights of what no direction gets more of: vpl_size()
    vec3 high;
    float cos_cone;  // cosine of the half-angle of the cone that holds all normals; -1: light leaves to all sides
    vec3 axis;       // of that cone, unit
    uint light;      // of a leaf
};

/// What makes the tree on a device.
struct VplTreePush {
    uint most;        // lights that there is room for
    uint count_word;  // of the counts: how many lights there are
    uint level;       // of the nodes that are there already, from the leaves; 0: none are
};

#ifdef __cplusplus
static_assert(sizeof(VplTreeNode) == 48, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif

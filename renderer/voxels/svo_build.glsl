// Nodes as the passes that build an octree find and make them. Define SVO_BUILD_NODES_BINDING (of set 0) before, and
// SVO_BUILD_READS_NODES where a pass only reads them.
#ifndef PHOTOND_SVO_BUILD_GLSL
#define PHOTOND_SVO_BUILD_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_build_shared.h"

layout(set = 0, binding = SVO_BUILD_NODES_BINDING, scalar)
#ifdef SVO_BUILD_READS_NODES
    readonly
#endif
    buffer Nodes { SvoNode nodes[]; };

/// The node of a level that a brick lies in, SVO_NO_DATA where there was no room for it; all levels above are flagged.
uint find_node(uint brick, uint level, SvoBuildPush push) {
    uint node = 0u;
    for (uint l = 1u; l <= level; ++l) {
        const uint shift = push.levels - l;
        const uint child = ((brick >> shift) & 1u) | (((brick >> (shift + 8u)) & 1u) << 1) |
                           (((brick >> (shift + 16u)) & 1u) << 2);
        node += child;
        if (node >= push.node_capacity) return SVO_NO_DATA;
        if (l < level) node = 8u * (nodes[node].info & SVO_TILE_MASK);
    }
    return node;
}

#ifndef SVO_BUILD_READS_NODES
/// Eight leaves of a level, from the least voxel of the node above on.
void make_tile(uint first, uint low, uint level, SvoBuildPush push) {
    const uint size = push.resolution >> level;
    for (uint child = 0u; child < 8u; ++child) {
        const uint at = low + size * ((child & 1u) | ((child & 2u) << 9) | ((child & 4u) << 18));
        nodes[first + child] = SvoNode(SVO_LEAF, SVO_NO_DATA, at, at + (size - 1u) * (1u | (1u << 10) | (1u << 20)));
    }
}
#endif

#endif

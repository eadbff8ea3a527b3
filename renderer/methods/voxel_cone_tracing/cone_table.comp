#version 460
// Which node or brick lies at each place of each level, so that no cone walks down the tree; a thread a place.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_tree_shared.h"

layout(local_size_x = CONE_GROUP) in;
layout(set = 0, binding = 0, scalar) readonly buffer ConeConstants { ConeTreeConstants cone_tree; };
layout(set = 0, binding = 1, scalar) readonly buffer SvoNodes { SvoNode svo_nodes[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer ConeTable { uint cone_table[]; };

uint find_cell(uint level, uvec3 place) {
    uint tile = 0u;
    for (uint at = 1u; at <= level; ++at) {
        const uvec3 bits = place >> (level - at) & 1u;
        const uint node = 8u * tile + (bits.x | bits.y << 1u | bits.z << 2u), info = svo_nodes[node].info;
        if ((info & SVO_FLAGGED) == 0u) return NO_CONE_CELL;
        if (at == level)
            return level == cone_tree.levels ? cone_tree.first_brick + svo_nodes[node].data : cone_tree.first_node + node;
        tile = info & SVO_TILE_MASK;
    }
    return NO_CONE_CELL;
}

void main() {
    const uint thread = flat_index();
    if (thread >= cone_tree.table_words) return;
    uint level = 1u, first = 0u;
    while (thread >= first + (1u << 3u * level)) first += 1u << 3u * level++;
    const uint mask = (1u << level) - 1u, at = thread - first;
    cone_table[thread] = find_cell(level, uvec3(at, at >> level, at >> 2u * level) & mask);
}

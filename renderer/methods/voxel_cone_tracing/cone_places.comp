#version 460
// Where each brick lies, in bricks; a thread a place of the last level.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_tree_shared.h"

layout(local_size_x = CONE_GROUP) in;
layout(set = 0, binding = 0, scalar) readonly buffer ConeConstants { ConeTreeConstants cone_tree; };
layout(set = 0, binding = 1, scalar) readonly buffer ConeTable { uint cone_table[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Places { uvec3 brick_places[]; };

void main() {
    const uint level = cone_tree.levels, first = ((1u << 3u * level) - 8u) / 7u, thread = flat_index();
    if (first + thread >= cone_tree.table_words || cone_table[first + thread] == NO_CONE_CELL) return;
    brick_places[cone_table[first + thread] - cone_tree.first_brick] =
        uvec3(thread, thread >> level, thread >> 2u * level) & ((1u << level) - 1u);
}

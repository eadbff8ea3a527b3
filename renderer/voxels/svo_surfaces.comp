#version 460
// The least number of the triangles in each voxel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_fragments.glsl"

layout(set = 0, binding = 3, scalar) readonly buffer Bricks { SvoBrick bricks[]; };
layout(set = 0, binding = 4, scalar) buffer Surfaces { uint surfaces[]; };

void main() {
    const uint i = tile_index() * SVO_GROUP + gl_LocalInvocationIndex;
    if (i >= tiles_state.elements) return;
    const uint node = find_node(fragments[i].brick, push.levels, push);
    if (node == SVO_NO_DATA) return;
    const uint brick = nodes[node].data, triangle = fragments[i].triangle;
    if (brick >= push.brick_capacity) return;
    uint first = push.surface_base + surfaces[brick];
    for (int word = 0; word < 2; ++word) {
        const uint mask = bricks[brick].mask[word];
        for (uint left = fragments[i].mask[word]; left != 0u; left &= left - 1u) {
            const uint at = first + uint(bitCount(mask & ((left & -left) - 1u)));
            if (at < surfaces.length() && surfaces[at] > triangle) atomicMin(surfaces[at], triangle);
        }
        first += uint(bitCount(mask));
    }
}

#version 460
// Fragments' voxels into the bricks.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_fragments.glsl"

layout(set = 0, binding = 3, scalar) buffer Bricks { SvoBrick bricks[]; };

void main() {
    const uint i = tile_index() * SVO_GROUP + gl_LocalInvocationIndex;
    if (i >= tiles_state.elements) return;
    const uint node = find_node(fragments[i].brick, push.levels, push);
    if (node == SVO_NO_DATA) return;
    const uint brick = nodes[node].data;
    if (brick >= push.brick_capacity) return;
    for (int word = 0; word < 2; ++word)
        if ((fragments[i].mask[word] & ~bricks[brick].mask[word]) != 0u)
            atomicOr(bricks[brick].mask[word], fragments[i].mask[word]);
}

#version 460
// Fragments' voxels into the bricks.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define DEVICE_TILES_BINDING 0
#define SVO_BUILD_NODES_BINDING 2
#define SVO_BUILD_READS_NODES
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Fragments { SvoFragment fragments[]; };
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

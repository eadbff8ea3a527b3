#version 460
// Level 1: the root's tile (thesis, 4.3.2, step 2).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define SVO_BUILD_NODES_BINDING 1
#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 0, scalar) buffer State { uint state[]; };

void main() {
    make_tile(0u, 0u, 1u, push);
    state[SVO_STATE_LEVEL_FIRST] = 0u;
    state[SVO_STATE_LEVEL_NODES] = 8u;
    state[SVO_STATE_NODES] = 8u;
}

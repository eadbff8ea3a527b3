#version 460
// Gives each flagged node of the level under way its tile of children, which are made with it, or its brick (thesis,
// 4.3.2, steps 6 and 8).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define DEVICE_TILES_BINDING 0
#define SVO_BUILD_NODES_BINDING 3
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer State { uint state[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Ranks { uint ranks[]; };

void main() {
    const uint i = tile_index() * SVO_GROUP + gl_LocalInvocationIndex;
    if (i >= tiles_state.elements) return;
    const uint node = state[SVO_STATE_LEVEL_FIRST] + i;
    if ((nodes[node].info & SVO_FLAGGED) == 0u) return;
    if (push.level == push.levels) {
        nodes[node].data = ranks[i];
        return;
    }
    const uint tile = (state[SVO_STATE_LEVEL_FIRST] + state[SVO_STATE_LEVEL_NODES]) / 8u + ranks[i];
    nodes[node].info = SVO_FLAGGED | tile;
    if (8u * tile + 8u <= push.node_capacity) make_tile(8u * tile, nodes[node].low, push.level + 1u, push);
}

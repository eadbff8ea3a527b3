#version 460
// 1 for each flagged node of the level under way, 0 for the others: their sums are the places of what they own.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define DEVICE_TILES_BINDING 0
#define SVO_BUILD_NODES_BINDING 1
#define SVO_BUILD_READS_NODES
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(set = 0, binding = 2, scalar) readonly buffer State { uint state[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Ranks { uint ranks[]; };

void main() {
    const uint i = tile_index() * SVO_GROUP + gl_LocalInvocationIndex;
    if (i >= tiles_state.elements) return;
    ranks[i] = (nodes[state[SVO_STATE_LEVEL_FIRST] + i].info & SVO_FLAGGED) != 0u ? 1u : 0u;
}

#version 460
// How many voxels each brick has.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define DEVICE_TILES_BINDING 0
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/voxels/svo_shared.h"

layout(local_size_x = SVO_GROUP) in;
layout(set = 0, binding = 1, scalar) readonly buffer Bricks { uvec2 bricks[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Counts { uint counts[]; };

void main() {
    const uint i = tile_index() * SVO_GROUP + gl_LocalInvocationIndex;
    if (i >= tiles_state.elements) return;
    counts[i] = uint(bitCount(bricks[i].x) + bitCount(bricks[i].y));
}

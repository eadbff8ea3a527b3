#version 460
// Ends a level (thesis, 4.3.2, step 7).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_build_shared.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 0, scalar) buffer State { uint state[]; };

void main() {
    const uint flagged = state[SVO_STATE_LEVEL_FLAGGED];
    if (push.level == push.levels) {
        state[SVO_STATE_BRICKS] = flagged;
        return;
    }
    const uint first = state[SVO_STATE_LEVEL_FIRST] + state[SVO_STATE_LEVEL_NODES];
    state[SVO_STATE_NODES] += 8u * flagged;
    state[SVO_STATE_LEVEL_FIRST] = first;
    state[SVO_STATE_LEVEL_NODES] = min(8u * flagged, push.node_capacity - first);
}

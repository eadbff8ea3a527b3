#version 460
// How many voxels come before each brick, as sums.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define SVO_GROUP_STARTS_BINDING 3
#include "renderer/voxels/svo_sums.glsl"

layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Bricks { uvec2 bricks[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer FirstVoxels { uint first_voxels[]; };  // of a brick, in its group

void main() {
    const uint count = min(state.bricks, push.brick_capacity), groups = sum_groups(count);
    const uint group = group_number(), brick = group * GROUP + group_thread();
    if (group >= groups) return;
    uint group_voxels, all_voxels;
    const uvec2 mask = brick < count ? bricks[brick] : uvec2(0u);
    const uint before = group_exclusive_sum(uint(bitCount(mask.x) + bitCount(mask.y)), group_voxels);
    if (brick < count) first_voxels[brick] = before;
    end_sums(groups, group_voxels, all_voxels);
}

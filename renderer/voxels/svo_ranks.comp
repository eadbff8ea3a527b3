#version 460
// How many nodes are flagged before each word of their bits, as sums; what that says of the tree's size, and of the
// passes that come.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define SVO_GROUP_STARTS_BINDING 3
#include "renderer/voxels/svo_sums.glsl"

layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Flags { uint flags[]; };
layout(set = 0, binding = 2, scalar) coherent buffer Ranks { uint ranks[]; };  // before each word, in its group
layout(set = 0, binding = 4, scalar) writeonly buffer Constants { SvoConstants constants; };

void main() {
    const uint groups = sum_groups(push.words), group = group_number(), word = group * GROUP + group_thread();
    if (group >= groups) return;
    uint group_flagged, all_flagged;
    const uint before = group_exclusive_sum(word < push.words ? uint(bitCount(flags[word])) : 0u, group_flagged);
    if (word < push.words) ranks[word] = before;
    if (!end_sums(groups, group_flagged, all_flagged) || group_thread() != 0u) return;
    const uint brick_word = SVO_FIRST_WORD(push.levels);
    const uint tiles = ranks[brick_word] + group_starts[brick_word / GROUP];
    state.nodes = 8u * tiles;
    state.bricks = all_flagged - tiles;
    const uint fragments = min(state.fragments, push.fragment_capacity);
    const uint bricks = min(state.bricks, push.brick_capacity);
    const bool follows = push.follows != 0u;
    state.fill_groups = rows_of_groups(groups_of((follows ? 0u : 32u * brick_word) + fragments, SVO_GROUP));
    state.brick_groups = rows_of_groups(sum_groups(bricks));
    state.surface_groups = rows_of_groups(groups_of((follows ? 0u : bricks) + fragments, SVO_GROUP));
    state.kept_groups = rows_of_groups(groups_of(bricks, SVO_GROUP));
    constants.surface_base = push.surfaces != 0u ? bricks : 0u;
}

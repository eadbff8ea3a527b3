#version 460
// A cut for the points of each subgroup, and a light of each of its nodes for each point: LightcutVpls::choose(). The
// threads keep the nodes on their way between them, node i at thread i modulo the subgroup's size: no other reads it.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_vote : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_tree.glsl"
#include "renderer/many_lights/vpl_choice_shared.h"
#include "renderer/many_lights/vpl_lighting.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { VplChoicePush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { VplLightingConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Counts { uint counts[VPL_COUNT_WORDS]; };
layout(set = 0, binding = CHOSEN_BINDING, scalar) writeonly buffer Chosen { ChosenVplRecord chosen[]; };
layout(set = 0, binding = CHOSEN_COUNTS_BINDING, scalar) writeonly buffer ChosenCounts { uint chosen_counts[]; };
layout(set = 0, binding = VPL_TREE_BINDING, scalar) readonly buffer Tree { VplTreeNode tree[]; };
layout(set = 0, binding = CUT_BINDING, scalar) buffer Cuts { CutNode cuts[]; };

uint leaves, lane, width, slots;

/// Where this thread keeps its k-th node.
uint slot_of(uint k) { return k * push.stride + flat_index(); }

/// What a node's lights can bring at most to the subgroup's points together; 0 where they surely bring nothing.
float bound_of(uint index, GBufferPoint point, bool here) {
    return subgroupAdd(here ? vpl_bound(tree[index], point.position, point.normal, constants.clamp_sq_m2) : 0.0);
}

void main() {
    const uint place = flat_index(), index = push.first_point + place;
    const bool in_piece = index < push.end_point;
    GBufferPoint point = points[min(index, push.end_point - 1u)];
    const bool here = in_piece && is_lit(point);
    if (in_piece && !here) chosen_counts[place] = 0u;
    if (!subgroupAny(here)) return;
    leaves = vpl_tree_leaves(counts[VPL_COUNT]);
    lane = gl_SubgroupInvocationID;
    width = gl_SubgroupSize;

    // The cut has `nodes` nodes; those that can bring nothing are not in it.
    uint nodes = 0;
    const float root = bound_of(VPL_TREE_ROOT, point, here);
    if (root > 0.0) {
        if (lane == 0u) cuts[slot_of(0u)] = CutNode(VPL_TREE_ROOT < leaves ? root : 0.0, VPL_TREE_ROOT);
        nodes = 1u;
    }
    // Parted nodes lead to one more or to fewer, so turns are bounded by the tree's depth times the cut's size.
    while (nodes > 0u && nodes < push.most) {
        float mine = 0.0;
        uint my_slot = 0u;
        for (uint k = 0; k * width + lane < nodes; ++k) {
            const float bound = cuts[slot_of(k)].bound;
            if (bound > mine) {
                mine = bound;
                my_slot = k;
            }
        }
        const float greatest = subgroupMax(mine);
        if (!(greatest > 0.0)) break;
        const uint owner = subgroupBallotFindLSB(subgroupBallot(mine == greatest));
        const uint slot = subgroupShuffle(my_slot, owner);
        uint parted = 0u;
        if (lane == owner) parted = cuts[slot_of(slot)].index;
        parted = subgroupShuffle(parted, owner);

        // One takes its parent's place, the other the next one; where neither can bring anything, the last node moves.
        CutNode child[2];
        uint children = 0;
        for (uint side = 0; side < 2u; ++side) {
            const uint below = 2u * parted + side;
            const float bound = bound_of(below, point, here);
            if (bound > 0.0) child[children++] = CutNode(below < leaves ? bound : 0.0, below);
        }
        if (children > 0u) {
            if (lane == owner) cuts[slot_of(slot)] = child[0];
        } else {
            --nodes;
            CutNode moved = CutNode(0.0, 0u);
            if (lane == nodes % width) moved = cuts[slot_of(nodes / width)];
            moved.bound = subgroupShuffle(moved.bound, nodes % width);
            moved.index = subgroupShuffle(moved.index, nodes % width);
            if (lane == owner) cuts[slot_of(slot)] = moved;
        }
        if (children == 2u) {
            if (lane == nodes % width) cuts[slot_of(nodes / width)] = child[1];
            ++nodes;
        }
    }

    const uint key = point_key(point, constants.seed, constants.pass);
    for (uint i = 0; i < nodes; ++i) {
        uint top = 0u;
        if (lane == i % width) top = cuts[slot_of(i / width)].index;
        top = subgroupShuffle(top, i % width);
        if (!here) continue;
        uint state = hash32(key ^ hash32(top ^ LIGHTCUT_SALT));
        uint node = top;
        while (node < leaves) {
            const float left = tree[2u * node].intensity, right = tree[2u * node + 1u].intensity;
            state += 0x9e3779b9u;
            const bool to_left =
                !(right > 0.0) || to_unit_float(hash32(state)) * tree[node].intensity < left;
            node = 2u * node + (to_left ? 0u : 1u);
        }
        chosen[i * push.stride + place] = ChosenVplRecord(tree[node].light, tree[top].intensity / tree[node].intensity);
    }
    if (here) chosen_counts[place] = nodes;
}

#version 460
// The tree's nodes and bricks. The first threads, one for each node above the bricks that there could be, make the tiles
// of those that are flagged (thesis, 4.3.2, steps 6 and 8); then one a fragment adds its voxels to its brick.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#include "renderer/voxels/svo_fragments.glsl"

layout(set = 0, binding = 5, scalar) writeonly buffer Nodes { SvoNode nodes[]; };
layout(set = 0, binding = 6, scalar) buffer Bricks { SvoBrick bricks[]; };

uint level_of_word(uint word) { return word < 2u ? word : 2u + uint(findMSB(7u * (word / 2u - 1u) + 1u)) / 3u; }

/// Where the node of a Morton code lies among the nodes of its level.
uvec3 node_place(uint code) {
    uvec3 place = uvec3(0u);
    for (uint bit = 0u; bit < SVO_MOST_LEVELS; ++bit)
        place |= (uvec3(code, code >> 1, code >> 2) >> 2u * bit) & (1u << bit);
    return place;
}

/// The children of the node that is bit `bit` of a word, if it is flagged.
void make_tile(uint word, uint bit) {
    if ((flags[word] >> bit & 1u) == 0u) return;
    const uint tile = rank_of_bit(word, bit);
    if (8u * tile + 8u > push.node_capacity) return;
    const uint level = level_of_word(word), code = 32u * (word - SVO_FIRST_WORD(level)) + bit;
    const uint size = BRICK_SIDE << (push.levels - level - 1u);  // a child's, in voxels
    const uvec3 place = 2u * size * node_place(code);

    const uint child_word = SVO_FIRST_WORD(level + 1u) + code / 4u, child_bit = 8u * (code % 4u);
    const uint flagged = flags[child_word] >> child_bit;
    const bool is_last = level + 1u == push.levels;
    uint rank = rank_of_bit(child_word, child_bit);
    if (is_last) rank -= first_brick();
    for (uint child = 0u; child < 8u; ++child) {
        const uvec3 low = place + size * (uvec3(child, child >> 1, child >> 2) & 1u), high = low + (size - 1u);
        SvoNode node = SvoNode(SVO_LEAF, SVO_NO_DATA, low.x | low.y << 10 | low.z << 20,
                               high.x | high.y << 10 | high.z << 20);
        if ((flagged >> child & 1u) != 0u) {
            node.info = SVO_FLAGGED | (is_last ? SVO_LEAF : rank);
            if (is_last) node.data = rank;
            ++rank;
        }
        nodes[8u * tile + child] = node;
    }
}

/// Gives how many voxels are set that no other fragment has set.
uint add_voxels(SvoFragment fragment) {
    const uint brick = brick_of(fragment.brick);
    uint added = 0u;
    if (brick >= push.brick_capacity) return added;
    for (int word = 0; word < 2; ++word) {
        const uint mask = fragment.mask[word];
        if ((mask & ~bricks[brick].mask[word]) != 0u)
            added += uint(bitCount(mask & ~atomicOr(bricks[brick].mask[word], mask)));
    }
    return added;
}

void main() {
    const uint i = flat_index(), nodes_above = 32u * SVO_FIRST_WORD(push.levels);
    if (i < nodes_above) {
        make_tile(i / 32u, i % 32u);
        return;
    }
    if (i - nodes_above >= fragment_count()) return;
    const uint added = subgroupAdd(add_voxels(fragments[i - nodes_above]));
    if (subgroupElect() && added > 0u) atomicAdd(state.voxels, added);
}

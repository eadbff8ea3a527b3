// The tiles of the tree's nodes. Define SVO_NODES_BINDING (of set 0) before, and begin_brick() after.
#ifndef PHOTOND_SVO_TILES_GLSL
#define PHOTOND_SVO_TILES_GLSL

#include "renderer/voxels/svo_node_ranks.glsl"
#include "renderer/voxels/svo_root.glsl"

/// Told of each brick, by its place and by the bit that flags it.
void begin_brick(uint brick, uint word, uint bit);

uint level_of_word(uint word) { return word < 2u ? word : 2u + uint(findMSB(7u * (word / 2u - 1u) + 1u)) / 3u; }

/// Where the node of a Morton code lies among the nodes of its level.
uvec3 node_place(uint code) {
    uvec3 place = uvec3(0u);
    for (uint bit = 0u; bit < SVO_MOST_LEVELS; ++bit)
        place |= (uvec3(code, code >> 1, code >> 2) >> 2u * bit) & (1u << bit);
    return place;
}

/// The children of the node that is bit `bit` of a word, if it is flagged. Where there is too little room the root has
/// none, so that nobody walks down to what is not there.
void make_tile(uint word, uint bit) {
    if ((flags[word] >> bit & 1u) == 0u) return;
    if (word == 0u && is_short(push)) {
        empty_root();
        return;
    }
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
            if (is_last) {
                node.data = rank;
                begin_brick(rank, child_word, child_bit + child);
            }
            ++rank;
        }
        nodes[8u * tile + child] = node;
    }
}

#endif

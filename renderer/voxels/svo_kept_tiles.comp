#version 460
// The nodes of a tree that follows from a kept one, and its bricks before anything is added to them: one thread for each
// node above the bricks that there could be.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define SVO_NODES_BINDING 5
#include "renderer/voxels/svo_tiles.glsl"

layout(set = 0, binding = 6, scalar) writeonly buffer Bricks { uvec2 bricks[]; };
layout(set = 0, binding = 7, scalar) readonly buffer KeptFlags { uint kept_flags[]; };
layout(set = 0, binding = 8, scalar) readonly buffer KeptRanks { uint kept_ranks[]; };
layout(set = 0, binding = 9, scalar) readonly buffer KeptRankStarts { uint kept_rank_starts[]; };
layout(set = 0, binding = 10, scalar) readonly buffer KeptBricks { uvec2 kept_bricks[]; };
layout(set = 0, binding = 11, scalar) writeonly buffer KeptPlaces { uint kept_places[]; };  // a brick's among those

uint kept_rank(uint word) { return kept_ranks[word] + kept_rank_starts[word / push.sum_group]; }

void begin_brick(uint brick, uint word, uint bit) {
    if (brick >= push.brick_capacity) return;
    uint kept = SVO_NO_DATA;
    if ((kept_flags[word] >> bit & 1u) != 0u)
        kept = kept_rank(word) + uint(bitCount(kept_flags[word] & ((1u << bit) - 1u))) -
               kept_rank(SVO_FIRST_WORD(push.levels));
    bricks[brick] = kept != SVO_NO_DATA ? kept_bricks[kept] : uvec2(0u);
    kept_places[brick] = kept;
}

void main() {
    const uint i = flat_index();
    if (i < 32u * SVO_FIRST_WORD(push.levels)) make_tile(i / 32u, i % 32u);
}

// The places of nodes and bricks in a tree that is made, by the bits that say which are flagged.
#ifndef PHOTOND_SVO_NODE_RANKS_GLSL
#define PHOTOND_SVO_NODE_RANKS_GLSL

#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 2, scalar) readonly buffer Flags { uint flags[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 4, scalar) readonly buffer RankStarts { uint rank_starts[]; };

/// Flagged nodes of all levels before a word of their bits, and before a bit of it. A node's rank among all that are
/// flagged is the number of its tile of children.
uint rank_of_word(uint word) { return ranks[word] + rank_starts[word / push.sum_group]; }
uint rank_of_bit(uint word, uint bit) { return rank_of_word(word) + uint(bitCount(flags[word] & ((1u << bit) - 1u))); }

/// Bricks' places are their ranks in the last level, counted from that of its first.
uint first_brick() { return rank_of_word(SVO_FIRST_WORD(push.levels)); }

#endif

// Fragments, and the bricks that they lie in.
#ifndef PHOTOND_SVO_FRAGMENTS_GLSL
#define PHOTOND_SVO_FRAGMENTS_GLSL

#include "renderer/voxels/svo_node_ranks.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Fragments { SvoFragment fragments[]; };

uint fragment_count() { return min(state.fragments, push.fragment_capacity); }
uint brick_of(uint code) { return rank_of_bit(SVO_FIRST_WORD(push.levels) + code / 32u, code % 32u) - first_brick(); }

#endif

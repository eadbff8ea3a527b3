#version 460
// Which blocks become one cell, for one of their children holds too few photons: for_each_cell() of stratification.cpp,
// from below. A thread a photon; those that begin blocks count them.
//
// A cell is the greatest joined block about its photons. Joined blocks lie within each other or apart: each adds to `covers`
// so that the sum of those before k says how many of them hold k and begin before it.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PHOTONS_BINDING 0
#define ORDER_BINDING 1
#define KEYS_BINDING 2
#define PLACES_BINDING 3
#include "renderer/methods/photon_splatting/stratification.glsl"

layout(local_size_x = STRATIFICATION_GROUP) in;
#include "renderer/backends/gpu/invocation.glsl"
layout(set = 0, binding = 4, scalar) buffer Covers { uint covers[]; };
layout(set = 0, binding = 5, scalar) buffer Joined { uint joined[]; };  // the greatest level of a joined block from there

void main() {
    const uint k = flat_index();
    if (k >= push.photons) return;
    const uint64_t code = sorted_code(k);
    if (code >= outside()) return;
    const uint64_t before = k > 0 ? sorted_code(k - 1) : ~0ul;
    for (uint level = 0; level < push.levels; ++level) {
        if (before >> 3 * level == code >> 3 * level) return;  // it begins no block of this level, nor of any above
        if (block_end(k, code, level) - k >= push.minimum_photons) continue;
        const uint begin = block_begin(k, code, level + 1), end = block_end(k, code, level + 1);
        atomicMax(joined[begin], level + 1);
        atomicAdd(covers[begin], 1u);
        atomicAdd(covers[end - 1], ~0u);  // one less
    }
}

#version 460
// The next step of each chain, to be looked at, a thread a chain. CPU twin: mutated() in path_selection.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/path_selection.glsl"

layout(set = 0, binding = 0, scalar) buffer Chains { PathChain chains[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Proposed { VplPath proposed[]; };

VplPath mutated(VplPath path, inout RandomStream random, uint element) {
    const uint x = random_stream_next_bits(random), y = random_stream_next_bits(random);
    const uint bits = random_stream_next_bits(random);
    if (random_stream_next(random) < CHAIN_LARGE_STEPS) return VplPath(x, y, element, 1.0, 0.0);
    const uint shift = 32u - CHAIN_STEP_BITS + (bits >> 8) % CHAIN_STEP_SCALES;
    path.point_x += (bits & 2u) != 0u ? x >> shift : 0u - (x >> shift);
    path.point_y += (bits & 4u) != 0u ? y >> shift : 0u - (y >> shift);
    if ((bits & CHAIN_REDRAWN_TAILS) != 0u) path.element = element;
    return path;
}

void main() {
    const uint chain = flat_index();
    if (chain >= push.chains) return;
    RandomStream random = numbers_of(PATH_STAGE_STEPS + push.step, chain);
    const VplPath state = VplPath(chains[chain].point_x, chains[chain].point_y, chains[chain].element, 1.0, 0.0);
    proposed[chain] = mutated(state, random, push.candidates + push.step * push.chains + chain);
    chains[chain].chance = random_stream_next(random);
}

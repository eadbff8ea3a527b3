#version 460
// Where chains start: at candidates drawn in proportion to their targets, a thread a chain. CPU twin: walk_chains() in
// path_selection.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define FLUX_SUMS_BINDING 0
#include "renderer/many_lights/flux_map.glsl"
#include "renderer/many_lights/path_selection.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Candidates { VplPath candidates[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Chains { PathChain chains[]; };

void main() {
    const uint chain = flat_index();
    if (chain >= push.chains) return;
    RandomStream random = numbers_of(PATH_STAGE_STARTS, 0u);
    const uint x = random_stream_next_bits(random), y = random_stream_next_bits(random);
    const Texel start = flux_choose(push.levels, rotated_halton_point(chain, uvec2(x, y)));
    const VplPath path = candidates[start.index];
    const float target = flux_sums[start.index];
    const float mean_target = target / (float(push.candidates) * start.probability);
    chains[chain] = PathChain(path.point_x, path.point_y, path.element, target, mean_target, 1u, 0u, 0.0,
                              path.choice);
}

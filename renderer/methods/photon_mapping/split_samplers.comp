#version 460
// The points of a pass's split samplers, for those sets that are asked for most: of the light samples, then of the gather
// rays.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define SAMPLER_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gathering/split_samplers.glsl"

layout(local_size_x = SPLIT_SAMPLERS_GROUP) in;
layout(push_constant, scalar) uniform Push { SplitSamplersPush push; };
layout(set = 0, binding = 1, scalar) writeonly buffer Points { uvec2 points[]; };

void main() {
    const uint i = flat_index();
    const uint sample_index = i / SPLIT_PREPARED_SETS;
    if (sample_index >= push.light_samples + push.gather_rays) return;
    const bool light = sample_index < push.light_samples;
    const SplitSamplers samplers = SplitSamplers(light ? push.light_samples : push.gather_rays, 0u);
    const uint element = split_element(samplers, light ? sample_index : sample_index - push.light_samples);
    points[i] = split_point(element, i % SPLIT_PREPARED_SETS);
}

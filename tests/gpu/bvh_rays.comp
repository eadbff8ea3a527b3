#version 460
// Rays' answers alone, for gpu_rays_bench: hits' distances, or whether they are blocked.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/backends/gpu/bvh.glsl"
#include "tests/gpu/twin.glsl"

layout(constant_id = 32) const bool ANY = false;

layout(set = 0, binding = 0, scalar) readonly buffer In { Ray rays[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { float answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    if (ANY)
        answers[i] = occluded(rays[i]) ? 1.0 : 0.0;
    else
        answers[i] = closest_hit(rays[i]).t;
}

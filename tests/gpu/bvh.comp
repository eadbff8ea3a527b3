#version 460
// Rays' answers by the ray structure.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/backends/gpu/bvh.glsl"
#include "tests/gpu/twin.glsl"

struct Answer {
    Hit hit;
    uint occluded;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Ray rays[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    answers[i] = Answer(closest_hit(rays[i]), occluded(rays[i]) ? 1u : 0u);
}

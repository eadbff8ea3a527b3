#version 460
// Walks in and out of solids.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/medium_stack.glsl"
#include "tests/gpu/twin.glsl"

const uint STEPS = 16;
struct Step {
    uint material;
    uint from_front;
};
struct Answer {
    uint top;      // after the step
    uint outside;  // of the material, before the step
    float outside_ior;
    vec3 transmittance;  // over `distance`
};
layout(set = 0, binding = 0, scalar) readonly buffer Distance { float distance; };
layout(set = 0, binding = 1, scalar) readonly buffer Steps { Step steps[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i * STEPS >= count) return;
    MediumStack media = make_medium_stack();
    for (uint k = i * STEPS; k < (i + 1) * STEPS; ++k) {
        const Step s = steps[k];
        const bool from_front = s.from_front != 0;
        const uint outside = medium_stack_outside_of(media, s.material, !from_front);
        const float outside_ior = medium_stack_outside_ior(media, s.material, !from_front);
        medium_stack_cross(media, s.material, from_front);
        answers[k] = Answer(medium_stack_top(media), outside, outside_ior, transmittance(media, distance));
    }
}

#version 460
// What is known of each light that light paths may start from.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/emission_sampling.glsl"
#include "tests/gpu/twin.glsl"

struct Answer {
    float probability;
    uint guided_by_position;
    uint lights;
};
layout(set = 0, binding = 0, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    Answer answer = Answer(0.0, 0u, emission_lights());
    if (i < answer.lights) {
        answer.probability = emission_probability(i);
        answer.guided_by_position = emission_guided_by_position(i) ? 1u : 0u;
    }
    answers[i] = answer;
}

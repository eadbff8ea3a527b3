#version 460
// Densities of lights' points and directions by both samplers.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/light_ends.glsl"
#include "tests/gpu/twin.glsl"

struct Query {
    vec3 p;
    vec3 n;
    vec3 wi;
    vec3 light_numbers;  // u_select, u
    float distance;      // from p, of an emission's start
    float u_light;
    vec2 u_position;
    vec2 u_direction;
};
struct End {
    float direct;
    float emission;
    float cosine;
    uint delta;
    uint infinite;
};
struct Answer {
    End of_sample;
    float pdf_direct_sa;  // of it; 0: nothing was drawn
    End of_emission;
    float direct_at_first_hit;  // of it; negative: nothing was drawn
    End of_environment;         // along wi
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

End end_of(LightEnd end) {
    return End(end.direct, end.emission, end.cosine, end.delta ? 1u : 0u, end.infinite ? 1u : 0u);
}

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query q = queries[i];
    Answer answer =
        Answer(end_of(NO_LIGHT_END), 0.0, end_of(NO_LIGHT_END), -1.0, end_of(light_end_of_environment(q.p, q.n, q.wi)));
    LightSample light_sample;
    if (sample_light(q.p, q.n, q.light_numbers.x, q.light_numbers.yz, light_sample))
        answer.of_sample = end_of(light_end_of_sample(light_sample, answer.pdf_direct_sa));
    EmissionSample emission;
    if (sample_emission(q.u_light, q.u_position, q.u_direction, emission)) {
        answer.of_emission = end_of(light_end_of_emission(emission));
        answer.direct_at_first_hit = light_direct_at_first_hit(emission, q.p, q.n, q.distance);
    }
    answers[i] = answer;
}

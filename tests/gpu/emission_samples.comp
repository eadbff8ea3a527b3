#version 460
// First steps of light paths.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/emission_sampling.glsl"
#include "tests/gpu/twin.glsl"

struct Query {
    float u_light;
    vec2 u_position;
    vec2 u_direction;
    uint light;  // NO_EMITTER: chosen by u_light
    float probability;
};
struct Answer {
    vec3 origin;
    vec3 direction;
    vec3 power_w;
    float range_m;
    uint light;
    uint source;
    uint lit;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query q = queries[i];
    EmissionSample emission;
    bool lit;
    if (q.light == NO_EMITTER)
        lit = sample_emission(q.u_light, q.u_position, q.u_direction, emission);
    else
        lit = sample_emission_light(q.light, q.probability, q.u_position, q.u_direction, emission);
    answers[i] = Answer(emission.ray.origin, emission.ray.direction, emission.power_w, emission.range_m,
                        emission.light, emission.source, lit ? 1u : 0u);
}

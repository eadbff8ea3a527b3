#version 460
// Samples of direct light.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/light_sampling.glsl"
#include "tests/gpu/twin.glsl"

struct Query {
    vec3 p;
    vec3 n;
    float u_select;
    vec2 u;
};
struct Answer {
    vec3 wi;
    float distance;
    vec3 target;
    vec3 radiance_over_pdf;
    float pdf_sa;
    uint delta;
    uint source;
    uint lit;
    vec3 shadow_direction;  // from p itself
    float shadow_t_max;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query q = queries[i];
    LightSample light_sample;
    const bool lit = sample_light(q.p, q.n, q.u_select, q.u, light_sample);
    const Ray ray = shadow_ray(light_sample, q.p);
    answers[i] = Answer(light_sample.wi, light_sample.distance, light_sample.target, light_sample.radiance_over_pdf,
                        light_sample.pdf_sa, light_sample.delta ? 1u : 0u, light_sample.source, lit ? 1u : 0u,
                        ray.direction, ray.t_max);
}

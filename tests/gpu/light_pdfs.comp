#version 460
// Densities of direct light's directions, and what the environment sends along them.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/light_sampling.glsl"
#include "tests/gpu/twin.glsl"

struct Query {
    vec3 p;
    vec3 n;
    vec3 wi;
    float distance;
    uint instance;  // NO_EMITTER: no triangle is met
    uint triangle;
};
struct Answer {
    float pdf_triangle;
    float pdf_environment;
    vec3 environment_radiance;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query q = queries[i];
    Answer answer;
    answer.pdf_triangle =
        q.instance == NO_EMITTER ? 0.0 : light_pdf_triangle(q.p, q.n, q.instance, q.triangle, q.wi, q.distance);
    answer.pdf_environment = light_pdf_environment(q.p, q.n, q.wi);
    answer.environment_radiance = environment_radiance(q.wi);
    answers[i] = answer;
}

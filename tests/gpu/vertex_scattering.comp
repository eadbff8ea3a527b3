#version 460
// Scattering at one place between a path from the eye and one from a light.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/vertex_scattering.glsl"
#include "tests/gpu/twin.glsl"

struct Place {
    Hit hit;
    float outside_ior;
};
struct Query {
    vec3 from;
    vec3 to;
};
struct Answer {
    EyeScattering of_eye;
    LightScattering of_light;
    vec3 lit_normal;
};
layout(set = 0, binding = 0, scalar) readonly buffer Places { Place place; };
layout(set = 0, binding = 1, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query query = queries[i];
    const ShadingPoint point = make_shading_point(place.hit, -query.from);
    const SurfaceVertex vertex = SurfaceVertex(point, make_bsdf(point, place.outside_ior), query.from);
    answers[i] = Answer(scatter_to_light(vertex, query.to), scatter_to_eye(vertex, query.to), lit_normal_of(vertex));
}

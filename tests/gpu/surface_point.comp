#version 460
// What shading asks of a place on a surface.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/emission.glsl"
#include "tests/gpu/twin.glsl"

struct Place {
    Hit hit;
    vec3 ray_direction;
    vec3 leaving;
    float outside_ior;
};
struct Answer {
    vec3 position;
    vec3 geometric_normal;
    vec3 smooth_normal;
    vec3 tangent;
    vec3 bitangent;
    vec3 normal;
    vec3 ray_origin;
    uint material;
    uint front_side;
    vec3 emitted_front;
    vec3 emitted_back;
    vec3 unlit;
    vec4 base_color;
    float coverage;
    vec3 albedo;
    float refraction_eta;
    uint lobes;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Place places[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Hit hit = places[i].hit;
    const ShadingPoint point = make_shading_point(hit, places[i].ray_direction);
    const Bsdf bsdf = make_bsdf(point, places[i].outside_ior);
    const uint lobes = (bsdf_scatters(bsdf) ? 1u : 0u) | (bsdf_is_lambert(bsdf) ? 2u : 0u) |
                       (bsdf_has_delta(bsdf) ? 4u : 0u) | (bsdf_has_non_delta(bsdf) ? 8u : 0u) |
                       (bsdf_has_non_delta_transmission(bsdf) ? 16u : 0u);
    answers[i] = Answer(point.position, point.geometric_normal, point.smooth_normal, point.shading.tangent,
                        point.shading.bitangent, point.shading.normal, ray_origin(point, places[i].leaving),
                        point.material, point.front_side ? 1u : 0u,
                        emitted_radiance(hit.instance, hit.triangle, hit.u, hit.v, true),
                        emitted_radiance(hit.instance, hit.triangle, hit.u, hit.v, false),
                        unlit_radiance(hit.instance, hit.triangle, hit.u, hit.v),
                        surface_base_color(hit.instance, hit.triangle, hit.u, hit.v),
                        surface_coverage(hit.instance, hit.triangle, hit.u, hit.v), bsdf_albedo(bsdf),
                        bsdf_refraction_eta(bsdf), lobes);
}

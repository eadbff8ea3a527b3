#version 460
// Path tracing, a thread a pixel from the eye to its end: CPU twin general_shading.cpp, with the same numbers. [Kajiya 1986]
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/path_tracing/path_tracing_shared.h"
#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/eye_vertex.glsl"

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { PathTracingPush push; };

/// One step of a path: what it finds, a light sample, and the next ray. False: it ends.
bool step_path(uint vertex, uint key, inout EyePath path, inout Ray ray, inout PathLight light, inout uint shadow_rays) {
    const Hit hit = closest_hit(ray);
    path.throughput *= transmittance(path.media, hit.t);
    if (!hit_valid(hit)) {
        add_environment(light, path, ray.direction);
        return false;
    }
    EyeVertex met;
    if (!meet_surface(path, vertex, hit, ray, light, met)) return false;
    const vec2 choice = sample_2d(key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE));
    if (bsdf_has_non_delta(met.bsdf)) {
        LightSample light_sample;
        const vec2 u = sample_2d(key, sample_set(vertex, SET_LIGHT_POINT));
        if (sample_light(path.position, path.lit_normal, choice.x, u, light_sample)) {
            const BsdfValue f = bsdf_evaluate(met.bsdf, met.wo, to_local(met.surface.shading, light_sample.wi),
                                              TRANSPORT_RADIANCE);
            if (!is_black(f.f_cos)) {
                const float weight = light_sample.delta ? 1.0 : power_heuristic(light_sample.pdf_sa, f.pdf_sa);
                ++shadow_rays;
                if (!occluded(shadow_ray(light_sample, ray_origin(met.surface, light_sample.wi)))) {
                    const vec3 radiance = weight * path.throughput * f.f_cos * light_sample.radiance_over_pdf;
                    if (path.scatterings == 0) light.direct += radiance; else light.indirect += radiance;
                }
            }
        }
    }
    const float u_lobe = ONLY_LAMBERT ? 0.0 : sample_2d(key, sample_set(vertex, SET_LOBE)).x;
    const vec2 u_direction = sample_2d(key, sample_set(vertex, SET_DIRECTION));
    return leave_surface(path, met.surface, bsdf_sample(met.bsdf, met.wo, u_lobe, u_direction), vertex + 1 >= eye.roulette_start,
                         choice.y, light, ray);
}

void main() {
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    uint pixel;
    if (tile < push.end_tile && pixel_of_tile(tile, gl_LocalInvocationIndex, pixel)) {
        EyePath path;
        Ray ray;
        uint key;
        start_eye_path(pixel, path, ray, key);
        PathLight light = no_light();
        uint vertex = 0, shadow_rays = 0;
        while (step_path(vertex, key, path, ray, light, shadow_rays)) ++vertex;
        store_light(pixel, light);
        count(COUNTER_CAMERA_RAYS, 1);
        count(COUNTER_BOUNCE_RAYS, vertex);
        count(COUNTER_SHADOW_RAYS, shadow_rays);
    }
}

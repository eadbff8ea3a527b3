#version 460
// Image-based lighting, a thread a pixel: CPU twins SpecularWalk::trace_tile() and EnvironmentLight.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#define PREFILTER_CONSTANTS_BINDING 4
#define PREFILTER_NODES_BINDING 5
#define LOBE_ALBEDO_TABLE_BINDING 6
#define WALK_LIGHT_SEEN(position, normal, source, key) \
    (source == light_source_of_environment() ? LIGHT_SEEN_NOTHING : LIGHT_SEEN_UNKNOWN)
#define DRAWS_LAMP_RAYS (NEEDS_AREA_LIGHTS && NEEDS_GLOSSY)  // draws_lamp_rays()
#define WALK_COMPETING_RAYS (DRAWS_LAMP_RAYS ? 1.0 : 0.0)
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/specular_walk.glsl"
#include "renderer/methods/image_based_lighting/image_based_lighting_shared.h"
#include "renderer/methods/image_based_lighting/prefiltered_environment.glsl"
#include "renderer/transport/bsdf_lobe_albedos.glsl"

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { ImageBasedLightingPush push; };

/// EnvironmentLight::reflected().
vec3 environment_light(WalkVertex met) {
    const LobeAlbedos albedos = bsdf_lobe_albedos(met.rough, met.wo);
    vec3 light = albedos.diffuse * prefiltered_by_white(met.surface.shading.normal);
    if (bsdf_is_lambert(met.rough)) return light;
    const float roughness = sqrt(albedos.alpha);
    if (!is_black(albedos.reflected)) {
        const vec3 mirrored = to_world(met.surface.shading, vec3(-met.wo.xy, met.wo.z));
        light += albedos.reflected * prefiltered_radiance(mirrored, roughness);
    }
    if (!is_black(albedos.transmitted))
        light += albedos.transmitted * prefiltered_radiance(met.ray_direction, roughness);
    return light;
}

/// LampRays::lamp_met().
vec3 lamp_met(WalkVertex met, uint vertex, uint key) {
    const float u_lobe = sample_2d(key, sample_set(vertex, SET_LOBE)).y;
    const vec2 u = sample_2d(key, sample_set(vertex, SET_DIRECTION));
    const BsdfSample by_lobe = bsdf_sample(met.rough, met.wo, u_lobe, u);
    if (!bsdf_sample_valid(by_lobe)) return vec3(0.0);
    const vec3 direction = to_world(met.surface.shading, by_lobe.wi);
    const Hit hit = closest_hit(Ray(ray_origin(met.surface, direction), direction, INFINITY));
    if (!hit_valid(hit)) return vec3(0.0);
    const ShadingPoint lamp = make_shading_point(hit, direction);
    if (!is_emissive(lamp.material)) return vec3(0.0);
    const vec3 emitted = emitted_radiance(hit.instance, hit.triangle, hit.u, hit.v, lamp.front_side);
    const vec3 lit_normal = bsdf_has_non_delta_transmission(met.rough) ? vec3(0.0) : met.surface.shading.normal;
    const float light_pdf =
        light_pdf_triangle(met.surface.position, lit_normal, hit.instance, hit.triangle, direction, hit.t);
    return power_heuristic(by_lobe.pdf_sa, light_pdf) * met.throughput * by_lobe.weight * emitted;
}

void light_pixel(EyePath path, Ray ray, uint key) {
    const uint pixel = path.pixel;
    PathLight light = no_light();
    uint vertices = 0, shadow_rays = 0, lamp_rays = 0;
    for (bool walking = true; walking; ++vertices) {
        WalkVertex met;
        walking = walk_vertex(vertices, key, 0.0, path, ray, light, shadow_rays, met);
        if (NEEDS_ENVIRONMENT && met.waits) light.direct += met.throughput * environment_light(met);
        if (DRAWS_LAMP_RAYS && met.waits) {
            light.direct += lamp_met(met, vertices, key);
            ++lamp_rays;
        }
    }
    store_light(pixel, light);
    count(COUNTER_CAMERA_RAYS, 1);
    count(COUNTER_BOUNCE_RAYS, vertices - 1 + lamp_rays);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}

void main() {
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    EyePath path;
    Ray ray;
    uint key;
    if (start_eye_path(tile, push.end_tile, gl_LocalInvocationIndex, path, ray, key)) light_pixel(path, ray, key);
}

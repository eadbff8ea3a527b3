// The body of gbuffer_walk.comp and gbuffer_walk_depth_maps.comp: CPU twins SpecularWalk::trace_tile() and GBufferSink.
// Before it come #version and the extensions, and WALK_LIGHT_SEEN (specular_walk.glsl) where shadows are known.

#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/gbuffer/gbuffer_walk_shared.h"
#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/specular_walk.glsl"

layout(set = 0, binding = 4, scalar) writeonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer GeneralPoints { GBufferGeneral general_points[]; };

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { GBufferWalkPush push; };

/// GBufferSink::offer(): keeps the vertex's point, or the one before, by chance.
void offer_point(uint index, uint vertex, uint key, WalkVertex met, inout GBufferPoint point) {
    const float share = max_component(met.throughput * bsdf_albedo(met.rough));
    if (!(share > 0.0)) return;
    point.total += share;
    if (point.kind != 0u && !(sample_2d(key, sample_set(vertex, SET_LOBE)).y * point.total < share)) return;
    point.position = met.surface.position;
    point.kind =
        GBUFFER_POINT | min(eye.max_scatterings - min(eye.max_scatterings, met.scatterings + 1u), GBUFFER_SCATTERINGS);
    point.normal = met.surface.shading.normal;
    point.depth_m = dot(met.surface.position - eye.camera.position, eye.camera.forward);
    point.geometric_normal = met.surface.geometric_normal;
    if (bsdf_is_lambert(met.rough)) {
        point.weight = met.throughput * met.rough.diffuse * (INV_PI / share);
        return;
    }
    if (bsdf_has_non_delta_transmission(met.rough)) point.normal = vec3(0.0);
    point.weight = met.throughput / share;
    point.kind |= GBUFFER_GENERAL;
    general_points[index] = GBufferGeneral(met.hit.t, met.hit.instance, met.hit.triangle, met.hit.u, met.hit.v,
                                           met.ray_direction, met.outside_ior, met.media.materials);
}

/// What a pixel's path finds and leaves.
void walk_pixel(EyePath path, Ray ray, uint key) {
    const uint pixel = path.pixel, index = split_point_of(push.split, pixel % eye.width, pixel / eye.width);
    GBufferPoint point = GBufferPoint(vec3(0.0), 0u, vec3(0.0), 0.0, vec3(0.0), pixel, vec3(0.0), 0.0);
    PathLight light = no_light();
    uint vertices = 0, shadow_rays = 0;
    for (bool walking = true; walking; ++vertices) {
        WalkVertex met;
        walking = walk_vertex(vertices, key, push.glossy_threshold, path, ray, light, shadow_rays, met);
        if (met.waits) offer_point(index, vertices, key, met, point);
    }
    point.weight *= point.total;
    points[index] = point;
    store_light(pixel, light);
    count(COUNTER_CAMERA_RAYS, 1);
    count(COUNTER_BOUNCE_RAYS, vertices - 1);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}

void main() {
    EyePath path;
    Ray ray;
    uint key;
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    if (start_eye_path(tile, push.end_tile, gl_LocalInvocationIndex, path, ray, key)) walk_pixel(path, ray, key);
}

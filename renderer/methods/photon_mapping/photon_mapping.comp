#version 460
// Photon mapping's second pass, a thread a pixel: from the eye through what is specular (CPU twin: specular_walk.cpp), and at
// each vertex what its rough part scatters of the maps' light (CPU twin: eye_pass.cpp). Where rays are to be gathered the
// points are left for photon_gather.comp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define NEAREST_GROUP (EYE_TILE * EYE_TILE)
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/gathering/photon_lookup.glsl"

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { EyePassPush push; };

layout(set = 0, binding = 9, scalar) buffer PointState { uint point_state[POINT_STATE_WORDS]; };
layout(set = 0, binding = 10, scalar) writeonly buffer Points { GatherPointRecord points[]; };
layout(set = 0, binding = 11, scalar) writeonly buffer LastPoints { uint last_points[]; };  // by thread of the piece

uint shadow_rays = 0, photons = 0, last_point = NO_POINT;

/// Light samples of a vertex; the rough part's share of them competes with `competing_rays`.
vec3 sample_lights(EyePath path, WalkVertex met, Bsdf specular, uint key, uint vertex, uint light_samples,
                   uint competing_rays) {
    vec3 sum = vec3(0.0);
    for (uint s = 0; s < light_samples; ++s) {
        const float u_choice =
            split_sample_2d(light_samplers(), s, key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE)).x;
        const vec2 u_light = split_sample_2d(light_samplers(), s, key, sample_set(vertex, SET_LIGHT_POINT));
        Ray to_light;
        vec3 radiance;
        LightSample light_sample;
        if (!walk_light_sample(path, met, specular, float(light_samples), float(competing_rays), u_choice, u_light,
                               to_light, radiance, light_sample))
            continue;
        ++shadow_rays;
        if (!occluded(to_light)) sum += radiance;
    }
    return sum;
}

/// A point that gathers rays.
void leave_point(WalkVertex met, uint key, uint rays, uint light_samples) {
    const uint place = atomicAdd(point_state[POINTS_WORD], 1u);
    if (place >= push.capacity) return;
    points[place] = GatherPointRecord(met.throughput, met.eta_scale, met.ray_direction, met.outside_ior,
                                      met.hit.instance, met.hit.triangle, met.hit.u, met.hit.v, met.media.materials,
                                      met.scatterings, key, rays, light_samples, last_point);
    last_point = place;
}

/// Light of the maps that a visible point scatters.
void look_up(WalkVertex point, uint turn, inout PathLight light) {
    const uint most = photon_scatterings_left(point.scatterings + 1);
    const DiscQuery query = disc_query(turn, DISC_FINE_BATCH);
    const MapEstimates maps = estimate_maps(point.surface, point.rough, point.wo, most, !FINAL_GATHER, query);
    photons += maps.caustic.photons + maps.global.photons;
    light.indirect += point.throughput * (maps.caustic.radiance + maps.global.radiance);
    if (layer_kept(LAYER_CAUSTIC) && point.scatterings == 0)
        light.caustic += point.throughput * maps.caustic.delta_radiance;
}

/// One vertex of a path: what it finds, light samples, its visible point, and the next ray. False: it ends.
bool step_path(uint vertex, uint key, inout EyePath path, inout Ray ray, inout PathLight light) {
    WalkVertex met;
    Bsdf specular;
    if (!walk_meet(vertex, mapping.glossy_threshold, path, ray, light, met, specular)) return false;
    const uint light_samples = split_of(mapping.light_samples, path.throughput, path.eta_scale);
    const uint rays = FINAL_GATHER ? split_of(mapping.gather_rays, path.throughput, path.eta_scale) : 0u;
    if (bsdf_has_non_delta(specular) || bsdf_has_non_delta(met.rough)) {
        const vec3 lit = sample_lights(path, met, specular, key, vertex, light_samples, met.waits ? rays : 0u);
        if (path.scatterings == 0) light.direct += lit; else light.indirect += lit;
    }
    if (met.waits) {
        look_up(met, disc_turn(sample_2d(key, sample_set(vertex, SET_DIRECTION))), light);
        if (FINAL_GATHER) leave_point(met, gather_key(key, vertex), rays, light_samples);
    }
    const float roulette =
        ONLY_LAMBERT ? 0.0 : sample_2d(key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE)).y;
    const bool on = walk_leave(vertex, key, met, specular, roulette, path, light, ray);
    path.pdf_sa /= float(light_samples);
    return on;
}

void main() {
    EyePath path;
    Ray ray;
    uint key;
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    if (start_eye_path(tile, push.end_tile, gl_LocalInvocationIndex, path, ray, key)) {
        uint vertex = 0;
        PathLight light = no_light();
        while (step_path(vertex, key, path, ray, light)) ++vertex;
        store_light(path.pixel, light);
        if (FINAL_GATHER) last_points[flat_index()] = last_point;
        if (layer_kept(LAYER_PHOTON_COUNT)) store_value(LAYER_PHOTON_COUNT, path.pixel, float(photons));
        count(COUNTER_CAMERA_RAYS, 1);
        count(COUNTER_BOUNCE_RAYS, vertex);
        count(COUNTER_SHADOW_RAYS, shadow_rays);
    }
}

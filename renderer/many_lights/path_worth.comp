#version 460
// The targets of light paths: what they bring to points that the eye sees, a thread a path; and what choices take
// their lights for. CPU twins CameraImportance::brought(), PathPilot::target(), choice_of() in path_selection.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/many_lights/camera_importance.glsl"
#include "renderer/many_lights/path_selection_shared.h"
#include "renderer/many_lights/vpl_tracer_shared.h"
#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = PATH_SELECTION_GROUP) in;
layout(push_constant, scalar) uniform Push { PathWorthPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 4, scalar) readonly buffer FirstOfPath { uint first_of_path[]; };
layout(set = 0, binding = 5, scalar) buffer Paths { VplPath paths[]; };
layout(set = 0, binding = 6, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 7, scalar) writeonly buffer Targets { float targets[]; };

uint rays = 0;

/// What is seen of it, and all.
vec2 brought(ReflectedPhotonRecord photon, uint element) {
    const float flux_w = max_component(photon.power_w);
    const uint first = hash32(element);
    const RandomStream random = importance_stream(push.seed, push.pass);
    vec2 sum = vec2(0.0);
    for (uint k = 0; k < CAMERA_IMPORTANCE_ASKED; ++k) {
        const uint drawn = (first + k) % CAMERA_IMPORTANCE_POINTS;
        const GBufferPoint point = points[importance_point(random, drawn, push.points)];
        const float light = unshadowed(point, photon.position, photon.normal, push.clamp_sq_m2) * flux_w;
        if (!(light > 0.0)) continue;
        const vec3 from = offset_ray_origin(point.position, importance_side(point, photon.position));
        ++rays;
        sum.y += light;
        if (!occluded(Ray(from, offset_ray_origin(photon.position, photon.normal) - from, kConnectionEnd)))
            sum.x += light;
    }
    return sum;
}

float target_of(float worth) {
    if (!(push.mean_worth > 0.0)) return 1.0;
    const float relative = worth / push.mean_worth;
    return relative > 0.0 ? min(relative, PATH_MOST_TARGET) + PATH_LEAST_TARGET : PATH_LEAST_TARGET;
}

void main() {
    const uint path = flat_index();
    if (path < push.count) {
        const uint begin = first_of_path[path];
        const uint end = path + 1u < push.count ? first_of_path[path + 1u] : state[REFLECTION_ORDERED];
        vec2 worth = vec2(0.0);
        for (uint i = begin; i < end; ++i) worth += brought(photons[order[i]], paths[push.first + path].element);
        targets[push.first + path] = target_of(worth.x);
        const float seen = worth.x / worth.y;
        paths[push.first + path].choice = seen > PATH_LEAST_CHOICE ? min(seen, 1.0) : PATH_LEAST_CHOICE;
        count(COUNTER_SHADOW_RAYS, rays);
    }
}

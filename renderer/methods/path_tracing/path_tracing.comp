#version 460
// Path tracing, a thread a pixel from the eye to its end. [Kajiya 1986]
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/path_tracing/path_tracing_shared.h"
#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/path_step.glsl"

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { PathTracingPush push; };

void main() {
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    EyePath path;
    Ray ray;
    uint key;
    if (!start_eye_path(tile, push.end_tile, gl_LocalInvocationIndex, path, ray, key)) return;
    PathLight light = no_light();
    uint vertices = 0, shadow_rays = 0;
    const uint pixel = path.pixel;
    follow_path(key, vertices, path, ray, light, shadow_rays);
    store_light(pixel, light);
    count(COUNTER_CAMERA_RAYS, 1);
    count(COUNTER_BOUNCE_RAYS, vertices - 1);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}

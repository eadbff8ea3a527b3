#version 460
// What the points of a pixel's path gathered, into its layers: a thread a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define EYE_BINDING 1
#define SAMPLER_BINDING 2
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/frame/device_image.glsl"
#include "renderer/eye/eye_scene.glsl"
#include "renderer/gathering/gathering_shared.h"

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(constant_id = GATHER_LANES_ID) const uint GATHER_LANES = 8;
layout(push_constant, scalar) uniform Push { GatherSumPush push; };
layout(set = 0, binding = 3, scalar) buffer PointState { uint point_state[POINT_STATE_WORDS]; };
layout(set = 0, binding = 4, scalar) readonly buffer Points { GatherPointRecord points[]; };
layout(set = 0, binding = 5, scalar) readonly buffer GatheredLight { GatheredRecord gathered_light[]; };
layout(set = 0, binding = 6, scalar) readonly buffer LastPoints { uint last_points[]; };

void main() {
    if (flat_index() == 0) atomicMax(point_state[MOST_POINTS_WORD], point_state[POINTS_WORD]);
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    uint pixel;
    if (tile >= push.end_tile || !pixel_of_tile(tile, gl_LocalInvocationIndex, pixel)) return;
    vec3 direct = vec3(0.0), indirect = vec3(0.0);
    uint photons = 0;
    for (uint place = last_points[flat_index()]; place != NO_POINT; place = points[place].next) {
        const vec3 to_pixel = points[place].throughput * (1.0 / float(points[place].rays));
        for (uint i = place * GATHER_LANES; i < (place + 1) * GATHER_LANES; ++i) {
            direct += to_pixel * gathered_light[i].direct;
            indirect += to_pixel * gathered_light[i].indirect;
            photons += gathered_light[i].photons;
        }
    }
    add_rgb(LAYER_DIRECT, pixel, direct);
    add_rgb(LAYER_INDIRECT, pixel, indirect);
    if (layer_kept(LAYER_PHOTON_COUNT))
        store_value(LAYER_PHOTON_COUNT, pixel, load_value(LAYER_PHOTON_COUNT, pixel) + float(photons));
}

#version 460
// Discs into depth maps: a thread a light and a point. The maps hold no distance at first.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/many_lights/imperfect_shadow_maps_shared.h"
#include "renderer/many_lights/vpl_shadow_maps.glsl"
#include "renderer/many_lights/vpl_shared.h"

layout(local_size_x = IMPERFECT_GROUP) in;
layout(push_constant, scalar) uniform Push { ImperfectSplatPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { OccluderPoint points[]; };
layout(set = 0, binding = 3, scalar) buffer Maps { uint reach_m[]; };  // bits of floats above 0 compare as these do

// A light this near a disc's plane, in radii, sees its edge alone.
const float LEAST_OFF_PLANE = 0.01;

void keep_nearest(uint light, uint texel, float distance_m, vec3 normal) {
    const float reach = vpl_map_reach(texel, push.resolution, distance_m, normal);
    atomicMin(reach_m[light * push.resolution * push.resolution + texel], floatBitsToUint(reach));
}

void splat(uint light, vec3 centre, vec3 normal) {
    const float distance_m = length(centre), off_plane_m = dot(normal, centre);
    // Discs near a light do not shadow it: where its own surface is bent they stand out of that.
    if (!(centre.z > 0.0 && distance_m > push.radius_m && abs(off_plane_m) > LEAST_OFF_PLANE * push.radius_m)) return;
    // A place moves by at most about the angle, all sides of the map being right angles.
    const float side = float(push.resolution);
    const vec2 at = vpl_map_place(centre) * side;
    const float reach_texels = asin(push.radius_m / distance_m) * side;
    const uvec2 low = uvec2(clamp(at - reach_texels, 0.0, side - 1.0));
    const uvec2 high = uvec2(clamp(at + reach_texels, 0.0, side - 1.0));
    for (uint row = low.y; row <= high.y; ++row)
        for (uint column = low.x; column <= high.x; ++column) {
            const uint texel = row * push.resolution + column;
            const vec3 direction = vpl_map_texel_direction(texel, push.resolution);
            const float t = off_plane_m / dot(normal, direction);
            const vec3 off_centre = t * direction - centre;
            if (t > 0.0 && dot(off_centre, off_centre) <= sqr(push.radius_m)) keep_nearest(light, texel, t, normal);
        }
}

void main() {
    const uint light = push.first_light + flat_index() / push.points, point = flat_index() % push.points;
    if (light >= min(counts[push.count_word], push.end_light)) return;
    const uint chosen = hash32(push.key ^ hash32(light * push.points + point)) % IMPERFECT_CHOICE;
    const OccluderPoint occluder = points[point * IMPERFECT_CHOICE + chosen];
    if (occluder.normal == vec3(0.0)) return;
    const Frame axes = make_frame(vpls[light].normal);
    splat(light, to_local(axes, occluder.position - vpls[light].position), to_local(axes, occluder.normal));
}

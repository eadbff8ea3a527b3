#version 460
// How many of a list's rays would meet each voxel if nothing stood between, where it has light and where it has none, a
// thread a voxel of a list: what the rays that do are judged by, so that a voxel counts by as much of it as is seen.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"

layout(local_size_x = LISTS_GROUP) in;
layout(push_constant, scalar) uniform Push { ListsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { VisibilityConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Voxels { ProxyVoxel voxels[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Lists { uint lists[]; };
#define VISIBILITY constants
#include "renderer/methods/visibility_filtering/marching_points.glsl"

/// Cosine over the squared distance, to a place on the side that light comes from; 0 behind it.
float falloff_to(GBufferPoint point, vec3 place, out vec3 to_place) {
    const vec3 offset = place - point.position;
    const float distance_sq = dot(offset, offset);
    to_place = offset * (1.0 / sqrt(max(distance_sq, 1e-37)));
    if (!(dot(point.geometric_normal, to_place) > 0.0)) return 0.0;
    return max(dot(point.normal, to_place), 0.0) / (distance_sq + constants.softening_sq_m2);
}

/// The areas with light and without of the voxel's surface that face a point, times the falloff there (area_seen()).
vec2 seen_of(ProxyVoxel voxel, GBufferPoint point) {
    vec3 to_place;
    const vec3 offset = voxel.middle - point.position;
    if (dot(offset, offset) > sqr(constants.near_m)) {
        const float falloff = falloff_to(point, voxel.middle, to_place);
        return falloff * area_seen(voxel, to_place);
    }
    vec2 sum = vec2(0.0);
    for (uint proxy = voxel.first; proxy < voxel.end; ++proxy) {
        const uvec4 place = grid_places[proxy];
        const float falloff = falloff_to(point, uintBitsToFloat(place.xyz), to_place);
        if (!(falloff > 0.0) || place.w == NO_PROXY) continue;
        const float cosine = -dot(proxy_normal(place.w), to_place);
        if (proxy_is_lit(place.w))
            sum.x += falloff * max(cosine, 0.0);
        else
            sum.y += falloff * abs(cosine);
    }
    return sum / constants.proxies_per_m2;
}

void main() {
    const uint slots = constants.grid.slots, thread = push.first * slots + flat_index();
    const uint list = thread / slots, slot = thread % slots;
    if (list >= push.end) return;
    const GBufferPoint point = points[marching_point(list)];
    vec2 expected = vec2(0.0);
    if (is_lit(point) && point.normal != vec3(0.0))
        expected = float(constants.rays) * INV_PI * seen_of(voxels[slot], point);
    const uint word = list * constants.words + 2u * slot;
    lists[word] = 0u;
    lists[word + 1u] = packHalf2x16(min(expected, vec2(60000.0)));
}

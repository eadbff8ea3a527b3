#version 460
// What the frame before found out at the same places, a group a list: the places that rays met there count once more, as
// if rays from here had met them. A place is looked up by where the last image showed it, and known by its normal, by
// lying on the same plane, and by whose surface it is.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define GRID_STARTS_BINDING 7
#define GRID_PLACES_BINDING 8
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/visibility_filtering/kept_lists_shared.h"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"
#include "renderer/photons/hash_grid.glsl"
#include "renderer/scene/camera_projection.glsl"

layout(constant_id = LISTS_ID) const uint LISTS = LISTS_COUNTS;

layout(local_size_x = LISTS_GROUP) in;
layout(push_constant, scalar) uniform Push { ListsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { VisibilityConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) buffer Lists { uint lists[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Kept { KeptConstants kept; };
layout(set = 0, binding = 4, scalar) readonly buffer KeptPoints { KeptPoint kept_points[]; };
layout(set = 0, binding = 5, scalar) readonly buffer KeptPlaces { vec3 kept_places[]; };  // by list of a point, and ray
layout(set = 0, binding = 6, scalar) writeonly buffer TakingPoints { TakingPoint taking_points[]; };
#define VISIBILITY constants
#include "renderer/methods/visibility_filtering/marching_points.glsl"
#include "renderer/methods/visibility_filtering/nearest_proxy.glsl"

shared TakingPoint taking;

/// Whose surface the point lies on, by a ray through it.
uint instance_at(GBufferPoint point) {
    const vec3 above = offset_ray_origin(point.position, point.geometric_normal);
    return closest_hit(Ray(above, offset_ray_origin(point.position, -point.geometric_normal) - above, 1.0)).instance;
}

/// Where the last image shows a place, counted in lists. False: behind the eye.
bool list_place(vec3 position, out vec2 place) {
    if (!project(kept.camera, position, place)) return false;
    place = (place - 0.5 - float(marching_offset())) / float(constants.march_side);
    return true;
}

/// Whether both points see the same, in the order of tests that reject most.
bool is_same_place(GBufferPoint point, uint instance, KeptPoint other, vec2 at) {
    if (other.lists == 0u || other.instance != instance) return false;
    if (dot(other.normal, point.geometric_normal) < constants.filter_normal) return false;
    const vec3 between = other.position - point.position;
    const float height_m = max(abs(dot(between, point.geometric_normal)), abs(dot(between, other.normal)));
    if (!(height_m <= agreeing_height_m(point))) return false;
    // What was seen in a mirror lies elsewhere than its pixel shows.
    vec2 place;
    return list_place(other.position, place) && all(lessThanEqual(abs(place - at), vec2(1.0)));
}

/// The nearest of the four about it.
uint find_list(GBufferPoint point, uint instance) {
    vec2 place;
    const ivec2 size = ivec2(constants.march_columns, constants.march_rows);
    // Written so that NaN is outside.
    if (!list_place(point.position, place) || !(all(greaterThan(place, vec2(-1.0))) && all(lessThan(place, vec2(size)))))
        return NO_LIST;
    uint found = NO_LIST;
    float nearest_sq = INFINITY;
    for (int i = 0; i < 4; ++i) {
        const ivec2 at = ivec2(floor(place)) + ivec2(i % 2, i / 2);
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
        const uint list = uint(at.y * size.x + at.x);
        const vec3 between = kept_points[list].position - point.position;
        if (!(dot(between, between) < nearest_sq) || !is_same_place(point, instance, kept_points[list], vec2(at)))
            continue;
        found = list;
        nearest_sq = dot(between, between);
    }
    return found;
}

TakingPoint take(GBufferPoint point) {
    TakingPoint taken = TakingPoint(KeptPoint(vec3(0.0), 0u, vec3(0.0), 0u), NO_LIST, 0u);
    if (!is_lit(point)) return taken;
    const uint instance = instance_at(point);
    taken.from = find_list(point, instance);
    if (taken.from != NO_LIST) taken.taken = kept_points[taken.from].lists;
    taken.now = KeptPoint(point.position, min(taken.taken + 1u, kept.most_lists), point.geometric_normal, instance);
    return taken;
}

void count_place(uint list, vec3 place, vec3 from) {
    const uint slot = grid_slot_of(constants.grid, place);
    if (LISTS == LISTS_COUNTS)
        atomicAdd(lists[list * constants.words + 2u * slot], is_lit_at(slot, place, place - from) ? 1u : 1u << 16);
    else
        atomicOr(lists[list * constants.words + slot / 32u], 1u << slot % 32u);
}

void main() {
    const uint list = push.first + flat_index() / LISTS_GROUP, thread = gl_LocalInvocationIndex;
    if (list >= push.end) return;
    if (thread == 0) {
        taking = take(points[marching_point(list)]);
        taking_points[list] = taking;
    }
    barrier();
    if (taking.taken == 0u) return;
    if (LISTS == LISTS_COUNTS)  // so many rays more are expected
        for (uint slot = thread; slot < constants.grid.slots; slot += LISTS_GROUP) {
            const uint word = list * constants.words + 2u * slot + 1u;
            const vec2 expected = float(taking.taken + 1u) * unpackHalf2x16(lists[word]);
            lists[word] = packHalf2x16(min(expected, vec2(60000.0)));
        }
    const uint first = taking.from * kept.most_lists * constants.rays;
    for (uint i = thread; i < taking.taken * constants.rays; i += LISTS_GROUP) {
        const vec3 place = kept_places[first + i];
        if (place.x < INFINITY) count_place(list, place, kept_points[taking.from].position);
    }
}

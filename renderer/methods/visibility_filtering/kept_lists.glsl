// The body of kept_lists.comp and kept_lists_svo.comp: what the frame before found out at the same places, a group a list.
// The places that rays met there count once more, as if rays from here had met them; rays whose way leads through what has
// moved are shot again. A place is looked up by where the last image showed it, and known by its normal, by lying on the
// same plane, and by whose surface it is. Before it come #version, the extensions and, as for march.glsl, FIRST_VOXEL.

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/visibility_filtering/kept_lists_shared.h"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"
#include "renderer/scene/camera_projection.glsl"

layout(constant_id = LISTS_ID) const uint LISTS = LISTS_COUNTS;

layout(local_size_x = LISTS_GROUP) in;
layout(push_constant, scalar) uniform Push { ListsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { VisibilityConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) buffer Lists { uint lists[]; };
layout(set = 0, binding = 3, scalar) readonly buffer KeptWords { uint kept_words[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer TakingPoints { TakingPoint taking_points[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer TakenPlaces { vec3 taken_places[]; };  // as they are now
#define COUNTERS_BINDING 6
#include "renderer/backends/gpu/counters.glsl"
#define VISIBILITY constants
#include "renderer/methods/visibility_filtering/counted_voxel.glsl"
#include "renderer/methods/visibility_filtering/marching_points.glsl"
#include "renderer/methods/visibility_filtering/nearest_proxy.glsl"

shared TakingPoint taking;

vec3 kept_vector(uint word) {
    return uintBitsToFloat(uvec3(kept_words[word], kept_words[word + 1u], kept_words[word + 2u]));
}
KeptPoint kept_point(uint list) {
    const uint word = KEPT_POINT_WORDS * list;
    return KeptPoint(kept_vector(word), kept_vector(word + 3u), kept_words[word + 6u], kept_words[word + 7u]);
}
vec3 kept_place(uint place) { return kept_vector(KEPT_POINT_WORDS * constants.kept.points + 3u * place); }

/// Whose surface the point lies on, by a ray through it.
uint instance_at(GBufferPoint point) {
    const vec3 above = offset_ray_origin(point.position, point.geometric_normal);
    return closest_hit(Ray(above, offset_ray_origin(point.position, -point.geometric_normal) - above, 1.0)).instance;
}

/// Where the last image shows a place, counted in lists. False: behind the eye.
bool list_place(vec3 position, out vec2 place) {
    if (!project(constants.kept.camera, position, place)) return false;
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
        const KeptPoint other = kept_point(list);
        const vec3 between = other.position - point.position;
        if (!(dot(between, between) < nearest_sq) || !is_same_place(point, instance, other, vec2(at))) continue;
        found = list;
        nearest_sq = dot(between, between);
    }
    return found;
}

/// Whether it lies where something has moved: about it all that was known is old.
bool is_amid_moves(vec3 position) {
    for (uint i = 0; i < constants.kept.boxes; ++i)
        if (all(greaterThan(position, constants.kept.moved[i].low - constants.disc_radius_m)) &&
            all(lessThan(position, constants.kept.moved[i].high + constants.disc_radius_m)))
            return true;
    return false;
}

TakingPoint take(GBufferPoint point) {
    TakingPoint taken = TakingPoint(KeptPoint(vec3(0.0), vec3(0.0), 0u, 0u), NO_LIST, 0u);
    if (!is_lit(point)) return taken;
    const uint instance = instance_at(point);
    if (!is_amid_moves(point.position)) taken.from = find_list(point, instance);
    if (taken.from != NO_LIST) taken.taken = kept_point(taken.from).lists;
    taken.now = KeptPoint(point.position, point.geometric_normal, min(taken.taken + 1u, constants.kept.most_lists), instance);
    return taken;
}

/// Whether a way leads through one of the boxes about what has moved, or near by: discs stand out.
bool is_in_doubt(vec3 from, vec3 direction, vec3 place) {
    const vec3 inverse = 1.0 / mix(direction, vec3(1e-20), lessThan(abs(direction), vec3(1e-20)));
    const float length_m = is_far(place) ? INFINITY : distance(from, place) + constants.disc_radius_m;
    for (uint i = 0; i < constants.kept.boxes; ++i) {
        const vec3 a = (constants.kept.moved[i].low - constants.disc_radius_m - from) * inverse,
                   b = (constants.kept.moved[i].high + constants.disc_radius_m - from) * inverse;
        const vec3 near = min(a, b), far = max(a, b);
        if (max(max(near.x, near.y), max(near.z, 0.0)) <= min(min(far.x, far.y), min(far.z, length_m))) return true;
    }
    return false;
}

/// What of a place that a ray met counts now, and where it is from now on.
vec3 count_place(uint list, GBufferPoint point, vec3 from, vec3 place) {
    const vec3 direction = direction_to(place, from);
    MetVoxel met = MetVoxel(0u, false, place);
    bool any_met = !is_far(place);
    if (is_in_doubt(from, direction, place)) {
        count(COUNTER_SHADOW_RAYS, 1);
        any_met = FIRST_VOXEL(point.position, side_towards(point, direction), direction, met);
        if (!any_met) met.place = far_place(direction);
    } else if (any_met) {
        met.slot = grid_slot_of(constants.grid, place);
        if (LISTS == LISTS_COUNTS) met.where_lit = is_lit_at(met.slot, place, direction);
    }
    if (any_met) count_voxel(list, met);
    return met.place;
}

void main() {
    const uint list = push.first + flat_index() / LISTS_GROUP, thread = gl_LocalInvocationIndex;
    if (list >= push.end) return;
    const GBufferPoint point = points[marching_point(list)];
    if (thread == 0) {
        taking = take(point);
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
    const vec3 from = kept_point(taking.from).position;
    const uint of_list = constants.kept.most_lists * constants.rays;
    for (uint i = thread; i < taking.taken * constants.rays; i += LISTS_GROUP) {
        vec3 place = kept_place(taking.from * of_list + i);
        if (place.x < INFINITY) place = count_place(list, point, from, place);
        taken_places[list * of_list + i] = place;
    }
}

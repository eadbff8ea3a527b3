#version 460
// The visibility filter [Chen 2014, equation 4]: a point sees what those about it see that lie on the same surface, a
// group a list. Voxels without light are left out.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/visibility_filtering/kept_lists_shared.h"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"
#include "renderer/gbuffer/gbuffer_point.glsl"

layout(constant_id = LISTS_ID) const uint LISTS = LISTS_COUNTS;
layout(constant_id = KEEPS_LISTS_ID) const bool KEEPS_LISTS = false;

layout(local_size_x = LISTS_GROUP) in;
layout(push_constant, scalar) uniform Push { ListsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { VisibilityConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Lists { uint lists[]; };
layout(set = 0, binding = 3, scalar) readonly buffer LitWords { uint lit_words[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Filtered { uint filtered[]; };
layout(set = 0, binding = 5, scalar) readonly buffer TakingPoints { TakingPoint taking_points[]; };
#define VISIBILITY constants
#include "renderer/methods/visibility_filtering/marching_points.glsl"

shared uint agreeing[LISTS_GROUP];  // lists
shared uint agreeing_count;
shared uint all_rays;         // of all agreeing lists, and of those that these took over
shared uint all_met;          // of them, by whatever voxel
shared uint bits[FILTER_MOST_WORDS];  // LISTS_INDICES

/// How many there are, then each voxel's number.
void write_indices(uint to) {
    uint count = 0;
    for (uint word = 0; word < constants.words; ++word)
        for (uint left = bits[word]; left != 0u; left &= left - 1u) filtered[to + 1u + count++] = 32u * word + uint(findLSB(left));
    filtered[to] = count;
}

/// How much is seen of a voxel where it has light, and where it has none: the rays of all agreeing lists that met it there,
/// over those that would if nothing stood between.
vec2 seen_shares(uint slot) {
    uvec2 met = uvec2(0u);
    vec2 expected = vec2(0.0);
    for (uint i = 0; i < agreeing_count; ++i) {
        const uint word = agreeing[i] * constants.words + 2u * slot, one = lists[word];
        met += uvec2(one & 0xffffu, one >> 16);
        expected += unpackHalf2x16(lists[word + 1u]);
    }
    if (met == uvec2(0u)) return vec2(0.0);
    atomicAdd(all_met, met.x + met.y);
    const vec2 shares = min(vec2(met) / max(expected, vec2(1e-30)), vec2(constants.most_seen));
    return mix(shares, vec2(greaterThan(met, uvec2(0u))), equal(expected, vec2(0.0)));
}

bool on_the_same_surface(GBufferPoint a, GBufferPoint b) {
    if (!is_lit(b) || dot(a.geometric_normal, b.geometric_normal) < constants.filter_normal) return false;
    const vec3 between = b.position - a.position;
    return max(abs(dot(between, a.geometric_normal)), abs(dot(between, b.geometric_normal))) <= agreeing_height_m(a);
}

void main() {
    const uint list = push.first + flat_index() / LISTS_GROUP, thread = gl_LocalInvocationIndex;
    if (list >= push.end) return;
    const GBufferPoint point = points[marching_point(list)];
    if (!is_lit(point)) return;
    if (thread == 0) agreeing_count = 0, all_rays = 0, all_met = 0;
    barrier();
    const uint side = constants.filter_side;
    const ivec2 size = ivec2(constants.march_columns, constants.march_rows);
    if (thread < side * side) {
        const ivec2 at = ivec2(list % constants.march_columns, list / constants.march_columns) +
                         ivec2(thread % side, thread / side) - int(side / 2u);
        if (all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size))) {
            const uint other = uint(at.y * size.x + at.x);
            if (other == list || on_the_same_surface(point, points[marching_point(other)])) {
                agreeing[atomicAdd(agreeing_count, 1u)] = other;
                atomicAdd(all_rays, constants.rays * (KEEPS_LISTS ? 1u + taking_points[other].taken : 1u));
            }
        }
    }
    barrier();
    const uint to = list * constants.list_words;
    if (LISTS == LISTS_COUNTS) {
        const uint shares = constants.list_words - 1u;
        for (uint slot = thread; slot < shares; slot += LISTS_GROUP) filtered[to + slot] = packHalf2x16(seen_shares(slot));
        barrier();
        if (thread == 0) filtered[to + shares] = floatBitsToUint(float(all_met) / float(all_rays));
        return;
    }
    for (uint word = thread; word < constants.words; word += LISTS_GROUP) {
        uint seen = 0;
        for (uint i = 0; i < agreeing_count; ++i) seen |= lists[agreeing[i] * constants.words + word];
        if (LISTS == LISTS_INDICES)
            bits[word] = seen & lit_words[word];
        else
            filtered[to + word] = seen & lit_words[word];
    }
    if (LISTS != LISTS_INDICES) return;
    barrier();
    if (thread == 0) write_indices(to);
}

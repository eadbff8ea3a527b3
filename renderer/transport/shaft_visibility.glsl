// Whether anything may stand between a point and a small region, and what: twin of transport/shaft_visibility.h, over the
// device's ray structure. Define before: SHAFT_MOST_BLOCKERS, triangles that are told one by one, and SHAFT_BLOCKERS, an
// array of so many uints for each place that shaft_blockers() is asked to use.
#ifndef PHOTOND_SHAFT_VISIBILITY_GLSL
#define PHOTOND_SHAFT_VISIBILITY_GLSL

#include "renderer/backends/gpu/bvh.glsl"

/// Where shafts end: points within a box and a sphere, and on a plane where there is one.
struct ShaftTarget {
    vec3 centre;  // of both, and on the plane
    vec3 half_extent;
    float radius_m;
    vec3 normal;  // unit, of the plane; 0: none
};

const uint SHAFT_UNKNOWN = SHAFT_MOST_BLOCKERS + 1;  // more than that, or who knows
const uint SHAFT_MOST_NODES = 32;  // that are looked at before the answer is "unknown"

/// The pyramid from the apex about the region's sphere.
struct Shaft {
    vec3 apex, apex_normal, axis;
    vec3 side[4];  // planes through the apex, normals outwards
    float far_m;
    float plane_m;      // of a flat target, along its normal, from the apex
    float tolerance_m;  // how far a point of a surface may lie off its plane by rounding
};

/// Whether a box, given from the apex, lies outside of the shaft.
bool box_outside(Shaft shaft, ShaftTarget target, vec3 centre, vec3 half_extent) {
    for (int i = 0; i < 4; ++i)
        if (dot(shaft.side[i], centre) - dot(abs(shaft.side[i]), half_extent) > 0.0) return true;
    const float along = dot(shaft.axis, centre), reach = dot(abs(shaft.axis), half_extent);
    if (along + reach < 0.0 || along - reach > shaft.far_m) return true;
    if (dot(shaft.apex_normal, centre) + dot(abs(shaft.apex_normal), half_extent) <= shaft.tolerance_m) return true;
    return target.normal != vec3(0.0) &&
           dot(target.normal, centre) + dot(abs(target.normal), half_extent) <= shaft.plane_m + shaft.tolerance_m;
}

/// ShaftVisibility::block_in_shaft() of one triangle: whether it may cut a segment.
bool triangle_in_shaft(Shaft shaft, ShaftTarget target, vec3 a, vec3 b, vec3 c) {
    a -= shaft.apex, b -= shaft.apex, c -= shaft.apex;
    for (int i = 0; i < 4; ++i)
        if (min(min(dot(shaft.side[i], a), dot(shaft.side[i], b)), dot(shaft.side[i], c)) > 0.0) return false;
    const vec3 along = vec3(dot(shaft.axis, a), dot(shaft.axis, b), dot(shaft.axis, c));
    if (max_component(along) < 0.0 || min(min(along.x, along.y), along.z) > shaft.far_m) return false;
    // All below the apex's horizon, or behind the target's plane.
    const vec3 n = shaft.apex_normal, m = target.normal;
    if (max(max(dot(n, a), dot(n, b)), dot(n, c)) <= shaft.tolerance_m) return false;
    const bool flat_target = m != vec3(0.0);
    if (flat_target && max(max(dot(m, a), dot(m, b)), dot(m, c)) <= shaft.plane_m + shaft.tolerance_m) return false;
    // Apex and region on one side of the triangle's plane.
    const vec3 edges = cross(b - a, c - a);
    const float length_sq = dot(edges, edges);
    if (!(length_sq > 1e-30)) return true;
    const vec3 plane = edges * (1.0 / sqrt(length_sq));
    const float offset = dot(plane, (a + b + c) * (1.0 / 3));
    const float of_apex = -offset, of_centre = dot(plane, target.centre - shaft.apex) - offset;
    float reach = dot(abs(plane), target.half_extent);
    if (flat_target) {  // a disc: along the plane's normal it reaches as far as the sine of the planes' angle says
        const vec3 sine = cross(plane, m);
        reach = min(reach, target.radius_m * sqrt(dot(sine, sine)));
    }
    const float tolerance = shaft.tolerance_m;
    return !((of_apex >= -tolerance && of_centre - reach >= -tolerance) ||
             (of_apex <= tolerance && of_centre + reach <= tolerance));
}

/// How many triangles may cut segments from the apex to points of the target, which are then kept at that place of
/// SHAFT_BLOCKERS, as places in the ray structure; or SHAFT_UNKNOWN. The apex lies on a surface, the points may: only
/// segments count that leave to the side that `apex_normal` (unit) shows to, and reach a flat target on the side of its
/// normal.
uint shaft_blockers(vec3 apex, vec3 apex_normal, ShaftTarget target, uint place) {
    const vec3 to = target.centre - apex;
    const float distance = length(to);
    if (!(distance > 1.01 * target.radius_m)) return SHAFT_UNKNOWN;
    Shaft shaft;
    shaft.apex = apex;
    shaft.apex_normal = apex_normal;
    shaft.axis = to / distance;
    shaft.far_m = distance + target.radius_m;
    shaft.plane_m = dot(target.normal, to);
    shaft.tolerance_m = 4e-6 * max_component(max(abs(scene_constants.bounds_min), abs(scene_constants.bounds_max)));
    const float sine = min(target.radius_m / distance * 1.0001 + 1e-6, 1.0), cosine = sqrt(1.0 - sine * sine);
    const Frame frame = make_frame(shaft.axis);
    shaft.side[0] = cosine * frame.tangent - sine * shaft.axis;
    shaft.side[1] = -cosine * frame.tangent - sine * shaft.axis;
    shaft.side[2] = cosine * frame.bitangent - sine * shaft.axis;
    shaft.side[3] = -cosine * frame.bitangent - sine * shaft.axis;

    uvec2 stack[BVH_STACK];  // first child that is a node; which of the children are nodes, and above that, are to be seen
    uint depth = 0, index = 0, found = 0;
    for (uint visited = 0; visited < SHAFT_MOST_NODES; ++visited) {
        const uint at = 5u * index;
        const uvec4 head = bvh_words(bvh_nodes[at]), links = bvh_words(bvh_nodes[at + 1u]);
        const uvec4 low_xy = bvh_words(bvh_nodes[at + 2u]), low_z_high_x = bvh_words(bvh_nodes[at + 3u]),
                    high_yz = bvh_words(bvh_nodes[at + 4u]);
        const vec3 spacing = uintBitsToFloat(uvec3(head.w << 23, head.w << 15, head.w << 7) & 0x7f800000u);
        const vec3 origin = uintBitsToFloat(head.xyz) - apex;
        uint nodes = 0, triangles = 0;
        for (uint i = 0; i < 8; ++i) {
            const bool upper = i >= 4;
            const uint meta = ((upper ? links.w : links.z) >> (8 * (i & 3u))) & 255u;
            if (meta == 0u) continue;
            const uvec3 low = (upper ? uvec3(low_xy.yw, low_z_high_x.y) : uvec3(low_xy.xz, low_z_high_x.x)) >> (8 * (i & 3u));
            const uvec3 high =
                (upper ? uvec3(low_z_high_x.w, high_yz.yw) : uvec3(low_z_high_x.z, high_yz.xz)) >> (8 * (i & 3u));
            const vec3 box_low = vec3(low & 255u), box_high = vec3(high & 255u);
            if (box_outside(shaft, target, origin + 0.5 * (box_low + box_high) * spacing,
                            0.5 * (box_high - box_low) * spacing * 1.00001 + shaft.tolerance_m))
                continue;
            if ((meta & 0x18u) == 0x18u) nodes |= 1u << i; else triangles |= (meta >> 5) << (meta & 31u);
        }
        for (; triangles != 0u; triangles &= triangles - 1u) {
            const uint record = links.y + uint(findLSB(triangles));
            const vec4 words_0 = uintBitsToFloat(bvh_words(bvh_triangles[3u * record]));
            const vec4 words_1 = uintBitsToFloat(bvh_words(bvh_triangles[3u * record + 1u]));
            const uvec2 words_2 = unpackUint2x32(bvh_triangles[3u * record + 2u].x);
            if (BVH_TWO_LEVELS && words_2.y == BVH_INSTANCE) return SHAFT_UNKNOWN;
            if (!triangle_in_shaft(shaft, target, words_0.xyz, vec3(words_0.w, words_1.xy),
                                   vec3(words_1.zw, uintBitsToFloat(words_2.x))))
                continue;
            if (found == SHAFT_MOST_BLOCKERS || words_2.y != BVH_OPAQUE) return SHAFT_UNKNOWN;
            SHAFT_BLOCKERS[place * SHAFT_MOST_BLOCKERS + found++] = record;
        }
        const uint all_nodes = head.w >> 24;
        if (nodes != 0u) stack[depth++] = uvec2(links.x, all_nodes | nodes << 8);
        if (depth == 0u) return found;
        const uvec2 above = stack[depth - 1];
        const uint slot = uint(findLSB(above.y >> 8));
        const uint left = above.y & ~(256u << slot);
        stack[depth - 1].y = left;
        if (left >> 8 == 0u) --depth;
        index = above.x + bitCount(above.y & ((1u << slot) - 1u));
    }
    return SHAFT_UNKNOWN;
}

/// Whether one of the `count` triangles at that place cuts the segment, whose ends are off their surfaces.
/// [Moeller and Trumbore 1997] Fast, Minimum Storage Ray/Triangle Intersection.
bool shaft_cut(uint place, uint count, vec3 from, vec3 to) {
    const vec3 direction = to - from;
    for (uint i = 0; i < count; ++i) {
        const uint record = SHAFT_BLOCKERS[place * SHAFT_MOST_BLOCKERS + i];
        const vec4 words_0 = uintBitsToFloat(bvh_words(bvh_triangles[3u * record]));
        const vec4 words_1 = uintBitsToFloat(bvh_words(bvh_triangles[3u * record + 1u]));
        const float last = uintBitsToFloat(unpackUint2x32(bvh_triangles[3u * record + 2u].x).x);
        const vec3 edge1 = vec3(words_0.w, words_1.xy) - words_0.xyz, edge2 = vec3(words_1.zw, last) - words_0.xyz;
        const vec3 p = cross(direction, edge2), s = from - words_0.xyz, q = cross(s, edge1);
        const float inverse = 1.0 / dot(edge1, p);
        const float u = dot(s, p) * inverse, v = dot(direction, q) * inverse, t = dot(edge2, q) * inverse;
        if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < 1.0) return true;
    }
    return false;
}

#endif

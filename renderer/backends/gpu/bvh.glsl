// Rays against the scene: closest_hit() and occluded(), with the meaning of Intersector (scene/intersector.h).
// CPU twin: bvh_trace.cpp. Arrays: bvh_shared.h.
//
// [Ylitie, Karras, Laine 2017] Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs. HPG.
// [Woop, Benthin, Wald 2013] Watertight Ray/Triangle Intersection. JCGT 2(1).
#ifndef PHOTOND_BVH_GLSL
#define PHOTOND_BVH_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "renderer/backends/gpu/bvh_shared.h"
#include "renderer/backends/gpu/scene.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/scene/alpha_test.glsl"
#include "renderer/scene/surface_color.glsl"

const uint NO_HIT = 0xffffffffu;

/// Where a ray met a triangle. Barycentrics: p = (1-u-v) p0 + u p1 + v p2.
struct Hit {
    float t;
    uint instance;
    uint triangle;
    float u;
    float v;
};
bool hit_valid(Hit hit) { return hit.instance != NO_HIT; }

/// Whether the top tree has instances of meshes in it (BvhData::two_levels).
layout(constant_id = BVH_TWO_LEVELS_ID) const bool BVH_TWO_LEVELS = true;

// Five to a node, three to a triangle. lavapipe loads word by word and lane by lane, or two words at once.
layout(set = SCENE_SET, binding = BVH_NODES_BINDING, std430) readonly buffer BvhNodes { u64vec2 bvh_nodes[]; };
layout(set = SCENE_SET, binding = BVH_TRIANGLES_BINDING, std430) readonly buffer BvhTriangles {
    u64vec2 bvh_triangles[];
};

uvec4 bvh_words(u64vec2 pair) { return uvec4(unpackUint2x32(pair.x), unpackUint2x32(pair.y)); }

/// A ray in the space of a tree.
struct BvhRay {
    vec3 origin;
    vec3 inverse;         // of the direction, whose components are kept from 0
    uint octant;          // bits 4, 2, 1: x, y, z of the direction are negative
    vec3 along;           // dot(along, p - origin) is t at p
    vec3 side_u, side_v;  // with the direction a right angle each
};

BvhRay make_bvh_ray(vec3 origin, vec3 direction) {
    BvhRay ray;
    ray.origin = origin;
    const float kLeast = 1e-20;
    const vec3 d = mix(direction, vec3(copysign(kLeast, direction.x), copysign(kLeast, direction.y),
                                       copysign(kLeast, direction.z)), lessThan(abs(direction), vec3(kLeast)));
    ray.inverse = 1.0 / d;
    ray.octant = (d.x < 0.0 ? 4u : 0u) | (d.y < 0.0 ? 2u : 0u) | (d.z < 0.0 ? 1u : 0u);
    const float inverse_square = 1.0 / dot(direction, direction);
    ray.along = direction * inverse_square;
    const Frame frame = make_frame(direction * sqrt(inverse_square));
    ray.side_u = frame.tangent;
    ray.side_v = frame.bitangent;
    return ray;
}

/// Bits of what the ray meets of four children, given their bytes: bit 24 + (slot ^ octant) for a node, those of the
/// meta byte for triangles.
uint bvh_hits_of_four(uint meta, uint octant, uvec3 near, uvec3 far, vec3 spacing, vec3 offset, float t_max) {
    // A byte of a node has bits 3 and 4 set.
    const uint is_node = ((meta & (meta << 1)) & 0x10101010u) >> 4;
    const uint places = (meta ^ (octant * is_node)) & 0x1f1f1f1fu;
    const uint counts = (meta >> 5) & 0x07070707u;
    uint hits = 0u;
    for (int i = 0; i < 4; ++i) {
        const vec3 enter = vec3(ivec3((near >> (8 * i)) & 255u)) * spacing + offset;
        const vec3 leave = vec3(ivec3((far >> (8 * i)) & 255u)) * spacing + offset;
        const float t_enter = max(max(enter.x, enter.y), max(enter.z, 0.0));
        // Three roundings of each distance [Ize 2013, Robust BVH Ray Traversal].
        const float t_leave = min(min(leave.x, leave.y), min(leave.z, t_max)) * 1.00000048;
        if (t_enter <= t_leave) hits |= ((counts >> (8 * i)) & 7u) << ((places >> (8 * i)) & 31u);
    }
    return hits;
}

/// Visits a node: its children that are met, as (first, bits). `nodes`: bits 24 to 31 by nearness, and the mask of the
/// children that are nodes below; `triangles`: bits 0 to 23.
void bvh_visit(uint index, BvhRay ray, float t_max, out uvec2 nodes, out uvec2 triangles) {
    const uint at = 5u * index;
    const uvec4 head = bvh_words(bvh_nodes[at]), links = bvh_words(bvh_nodes[at + 1u]);
    const uvec4 low_xy = bvh_words(bvh_nodes[at + 2u]), low_z_high_x = bvh_words(bvh_nodes[at + 3u]),
                high_yz = bvh_words(bvh_nodes[at + 4u]);
    const vec3 spacing = ray.inverse * uintBitsToFloat(uvec3(head.w << 23, head.w << 15, head.w << 7) & 0x7f800000u);
    const vec3 offset = (uintBitsToFloat(head.xyz) - ray.origin) * ray.inverse;
    const bvec3 negative = lessThan(ray.inverse, vec3(0.0));
    const uvec3 low_0 = uvec3(low_xy.xz, low_z_high_x.x), low_1 = uvec3(low_xy.yw, low_z_high_x.y);
    const uvec3 high_0 = uvec3(low_z_high_x.z, high_yz.xz), high_1 = uvec3(low_z_high_x.w, high_yz.yw);
    const uint hits =
        bvh_hits_of_four(links.z, ray.octant, mix(low_0, high_0, negative), mix(high_0, low_0, negative), spacing,
                         offset, t_max) |
        bvh_hits_of_four(links.w, ray.octant, mix(low_1, high_1, negative), mix(high_1, low_1, negative), spacing,
                         offset, t_max);
    nodes = uvec2(links.x, (hits & 0xff000000u) | (head.w >> 24));
    triangles = uvec2(links.y, hits & 0x00ffffffu);
}

/// Whether the ray meets the triangle in (0, t_max). An edge that two triangles share is seen by both with exactly
/// opposite signs, so that no ray slips between them: the corners are projected along the ray, the same way for each
/// triangle, and all products are rounded before they are subtracted (`precise`). [Woop et al. 2013] shear them along
/// the greatest axis instead of turning them; that needs components chosen at run time.
bool bvh_meet_triangle(vec3 corner_0, vec3 corner_1, vec3 corner_2, BvhRay ray, float t_max, out float t, out float u,
                       out float v) {
    precise const vec3 a = corner_0 - ray.origin, b = corner_1 - ray.origin, c = corner_2 - ray.origin;
    precise const vec2 pa = vec2(dot(a, ray.side_u), dot(a, ray.side_v));
    precise const vec2 pb = vec2(dot(b, ray.side_u), dot(b, ray.side_v));
    precise const vec2 pc = vec2(dot(c, ray.side_u), dot(c, ray.side_v));
    precise const vec3 w = vec3(pc.x * pb.y - pc.y * pb.x, pa.x * pc.y - pa.y * pc.x, pb.x * pa.y - pb.y * pa.x);
    const float inverse = 1.0 / (w.x + w.y + w.z);
    t = dot(w, vec3(dot(a, ray.along), dot(b, ray.along), dot(c, ray.along))) * inverse;
    u = w.y * inverse;
    v = w.z * inverse;
    const bool inside = min(min(w.x, w.y), w.z) >= 0.0 || max(max(w.x, w.y), w.z) <= 0.0;
    return inside && t > 0.0 && t < t_max;  // false for a sum of 0: t is no number
}

/// Goes through the tree; `any`, a constant: the first hit found will do, and only hit_valid() of it counts.
///
/// Measured on lavapipe in scenes of 76,000 to 263,000 triangles, rays a processor second: these nodes serve 1.4 to 2.0
/// times the rays that plain binary ones do (64 bytes, both boxes as floats). Nodes in a loop of their own before the
/// triangles are 0 to 20 % slower for closest hits, one triangle an iteration 0 to 25 %, loads of single words 5 to 15 %;
/// the stack in shared memory makes no difference.
Hit bvh_trace(Ray world_ray, const bool any) {
    BvhRay ray = make_bvh_ray(world_ray.origin, world_ray.direction);
    Hit hit = Hit(world_ray.t_max, NO_HIT, 0u, 0.0, 0.0);
    uint place = NO_HIT;           // of the nearest triangle
    uint instance = NO_HIT;        // that the ray is in
    uint instance_depth = NO_HIT;  // the stack's, when it went in
    uvec2 stack[BVH_STACK];
    uint depth = 0u;
    uvec2 nodes = uvec2(0u, world_ray.t_max > 0.0 ? 0x80000000u : 0u);
    uvec2 triangles = uvec2(0u);
    while (nodes.y > 0x00ffffffu || triangles.y != 0u) {
        if (triangles.y == 0u) {
            const uint bit = uint(findMSB(nodes.y));
            nodes.y ^= 1u << bit;
            const uint slot = (bit - 24u) ^ ray.octant;
            const uint index = nodes.x + bitCount(nodes.y & ((1u << slot) - 1u));
            if (nodes.y > 0x00ffffffu) stack[depth++] = nodes;
            bvh_visit(index, ray, hit.t, nodes, triangles);
        }
        while (triangles.y != 0u) {
            const uint record = triangles.x + uint(findLSB(triangles.y));
            triangles.y &= triangles.y - 1u;
            const vec4 words_0 = uintBitsToFloat(bvh_words(bvh_triangles[3u * record]));
            const vec4 words_1 = uintBitsToFloat(bvh_words(bvh_triangles[3u * record + 1u]));
            const uvec2 words_2 = unpackUint2x32(bvh_triangles[3u * record + 2u].x);
            const uint kind = words_2.y;
            if (BVH_TWO_LEVELS && kind == BVH_INSTANCE) {
                if (triangles.y != 0u) stack[depth++] = triangles;
                if (nodes.y > 0x00ffffffu) stack[depth++] = nodes;
                triangles.y = 0u;
                instance_depth = depth;
                const uvec2 link = unpackUint2x32(bvh_triangles[3u * record + 2u].y);
                instance = link.y;
                const uint transform = 3u * floatBitsToUint(words_0.x);
                const vec4 m0 = uintBitsToFloat(bvh_words(bvh_triangles[transform]));
                const vec4 m1 = uintBitsToFloat(bvh_words(bvh_triangles[transform + 1u]));
                const vec4 m2 = uintBitsToFloat(bvh_words(bvh_triangles[transform + 2u]));
                const mat3 linear = mat3(m0.xyz, vec3(m0.w, m1.xy), vec3(m1.zw, m2.x));
                ray = make_bvh_ray(linear * world_ray.origin + m2.yzw, linear * world_ray.direction);
                nodes = uvec2(link.x, 0x80000000u);
                continue;
            }
            float t, u, v;
            if (!bvh_meet_triangle(words_0.xyz, vec3(words_0.w, words_1.xy),
                                   vec3(words_1.zw, uintBitsToFloat(words_2.x)), ray, hit.t, t, u, v))
                continue;
            if (NEEDS_ALPHA && kind == BVH_COVERED_IN_PART) {
                const uvec2 link = unpackUint2x32(bvh_triangles[3u * record + 2u].y);
                const uint in_instance = BVH_TWO_LEVELS && instance != NO_HIT ? instance : link.y;
                if (passes_surface(world_ray, in_instance, link.x, surface_coverage(in_instance, link.x, u, v)))
                    continue;
            }
            hit.t = t;
            hit.u = u;
            hit.v = v;
            hit.instance = instance;
            place = record;
            if (any) {
                nodes.y = triangles.y = 0u;
                depth = 0u;
            }
        }
        if (nodes.y <= 0x00ffffffu && depth > 0u) {
            if (BVH_TWO_LEVELS && depth == instance_depth) {
                instance = instance_depth = NO_HIT;
                ray = make_bvh_ray(world_ray.origin, world_ray.direction);
            }
            nodes = stack[--depth];
            if (BVH_TWO_LEVELS && nodes.y <= 0x00ffffffu) {
                triangles = nodes;
                nodes.y = 0u;
            }
        }
    }
    if (place == NO_HIT) return Hit(INFINITY, NO_HIT, 0u, 0.0, 0.0);
    if (any) {
        hit.instance = 0u;
        return hit;
    }
    const uvec2 link = unpackUint2x32(bvh_triangles[3u * place + 2u].y);
    hit.triangle = link.x;
    if (!BVH_TWO_LEVELS || hit.instance == NO_HIT) hit.instance = link.y;
    return hit;
}

/// The nearest hit with 0 < t < ray.t_max.
Hit closest_hit(Ray ray) { return bvh_trace(ray, false); }
/// Whether anything opaque lies in (0, ray.t_max).
bool occluded(Ray ray) { return hit_valid(bvh_trace(ray, true)); }

#endif

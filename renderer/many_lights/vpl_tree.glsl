// GLSL twin of many_lights/vpl_tree.h. Keys and boxes are the same to the bit, cones and bounds but for rounding.
#ifndef PHOTOND_VPL_TREE_GLSL
#define PHOTOND_VPL_TREE_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/many_lights/vpl.glsl"
#include "renderer/many_lights/vpl_tree_shared.h"

const VplTreeNode VPL_TREE_NOTHING =
    VplTreeNode(vec3(0.0), 0.0, vec3(0.0), 1.0, vec3(0.0), NO_VPL);

float vpl_size(Vpl vpl) {
    const float most = max_component(vpl.intensity) * (vpl_is_lambert(vpl) ? max(vpl.correction, 1.0) : INV_PI);
    return vpl.choice > 0.0 ? vpl.choice * most : most;
}

/// std::bit_ceil(max(lights, 1)).
uint vpl_tree_leaves(uint lights) { return lights <= 1u ? 1u : 2u << findMSB(lights - 1u); }

/// Uints in the floats' order.
uint ordered_bits(float x) {
    const uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
float float_from_ordered(uint bits) {
    return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits);
}

float vpl_key_scale(vec3 extent) {
    const int exponent = floatBitsToInt(max_component(extent)) >> 23;
    return intBitsToFloat(min(int(VPL_KEY_AXIS_BITS) - 1 + 254 - exponent, 254) << 23);
}

/// The lowest ten bits of x, two zeros between each.
uint spread_bits(uint x) {
    x &= 0x3ffu;
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

uint vpl_key(Vpl vpl, vec3 low, float scale) {
    const uint fine_bits = 3u * (VPL_KEY_AXIS_BITS - VPL_KEY_COARSE_BITS);
    precise const vec3 place_of_cell = (vpl.position - low) * scale;
    const uvec3 cell = min(uvec3(place_of_cell), uvec3((1u << VPL_KEY_AXIS_BITS) - 1u));
    const uint place = spread_bits(cell.x) | spread_bits(cell.y) << 1 | spread_bits(cell.z) << 2;
    const vec3 a = abs(vpl.normal);
    const uint axis = a.x >= a.y && a.x >= a.z ? 0u : a.y >= a.z ? 1u : 2u;
    const uint facing = 2u * axis + (vpl.normal[axis] < 0.0 ? 1u : 0u);
    return place >> fine_bits << (fine_bits + 3u) | facing << fine_bits | (place & ((1u << fine_bits) - 1u));
}

VplTreeNode vpl_leaf(Vpl vpl, uint light) {
    const float size = vpl_size(vpl);
    if (!(size > 0.0)) return VPL_TREE_NOTHING;
    return VplTreeNode(vpl.position, size, vpl.position, vpl_is_lambert(vpl) ? 1.0 : -1.0, vpl.normal, light);
}

/// The cosine of the half-angle of the cone about `axis` that holds the node's cone; -1 from half a turn on.
float cos_about(vec3 axis, VplTreeNode node) {
    const float cos_turn = min(dot(axis, node.axis), 1.0);
    if (cos_turn + node.cos_cone <= 0.0) return -1.0;
    const float sines_sq = (1.0 - cos_turn * cos_turn) * max(1.0 - node.cos_cone * node.cos_cone, 0.0);
    return cos_turn * node.cos_cone - sqrt(sines_sq);
}

VplTreeNode merge_vpl_nodes(VplTreeNode a, VplTreeNode b) {
    if (!(a.intensity > 0.0) || !(b.intensity > 0.0)) {
        VplTreeNode node = b;
        if (a.intensity > 0.0) node = a;
        node.light = NO_VPL;
        return node;
    }
    VplTreeNode node =
        VplTreeNode(min(a.low, b.low), a.intensity + b.intensity, max(a.high, b.high), -1.0, a.axis, NO_VPL);
    if (a.axis == b.axis) {
        node.cos_cone = min(a.cos_cone, b.cos_cone);
        return node;
    }
    const vec3 sum = a.axis + b.axis;
    const float length_sq = dot(sum, sum);
    if (length_sq < 1e-6) return node;
    node.axis = sum * (1.0 / sqrt(length_sq));
    node.cos_cone = min(cos_about(node.axis, a), cos_about(node.axis, b));
    return node;
}

/// Of the places in a box, the greatest cosine at the point between an axis and the way there.
float max_cosine(float along, float spread, float distance_sq, float radius, float inverse_nearest) {
    const float across_sq = distance_sq - along * along, rounding = 1e-6 * distance_sq;
    const float z = along + spread;
    const float t = z >= 0.0 ? max(sqrt(max(across_sq - rounding, 0.0)) - radius, 0.0)
                             : sqrt(max(across_sq, 0.0) + rounding) + radius;
    const float cosine = z / sqrt(max(z * z + t * t, 1e-36));
    return z >= 0.0 ? min(cosine, z * inverse_nearest) : cosine;
}

/// The most irradiance that a node can bring to a point; `normal` 0: from all sides.
float vpl_bound(VplTreeNode node, vec3 position, vec3 normal, float clamp_sq_m2) {
    if (!(node.intensity > 0.0)) return 0.0;
    const vec3 extent = 0.5 * (node.high - node.low);
    const float radius = sqrt(dot(extent, extent));
    const vec3 d = 0.5 * (node.low + node.high) - position;
    const float distance_sq = dot(d, d);
    const vec3 gap = max(abs(d) - extent, vec3(0.0));
    const float nearest_sq = max(dot(gap, gap), 1e-20);
    const float inverse_nearest = 1.0 / sqrt(nearest_sq);

    float cosines = 1.0;
    if (normal != vec3(0.0)) {
        const float spread = dot(abs(normal), extent);
        cosines = clamp(max_cosine(dot(normal, d), spread, distance_sq, radius, inverse_nearest), 0.0, 1.0);
    }
    if (node.cos_cone > -1.0) {
        const float sent =
            max_cosine(-dot(node.axis, d), dot(abs(node.axis), extent), distance_sq, radius, inverse_nearest);
        const float sines_sq = max(1.0 - sent * sent, 0.0) * max(1.0 - node.cos_cone * node.cos_cone, 0.0);
        cosines *= sent >= node.cos_cone ? 1.0 : clamp(sent * node.cos_cone + sqrt(sines_sq), 0.0, 1.0);
    }
    return node.intensity * cosines / max(nearest_sq, clamp_sq_m2);
}

#endif

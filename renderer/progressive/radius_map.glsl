// GLSL twin of progressive/radius_map.h. Define RADIUS_MAP_BINDING (of set 0) before: the records of the maps.
#ifndef PHOTOND_RADIUS_MAP_GLSL
#define PHOTOND_RADIUS_MAP_GLSL

#include "renderer/core/rng.glsl"
#include "renderer/progressive/radius_map_shared.h"

layout(set = 0, binding = RADIUS_MAP_BINDING, std430) readonly buffer RadiusMaps { RadiusMapRecord radius_maps[]; };

RadiusMapRecord radius_leaf_at(uint first_node, uint first_leaf, vec3 p) {
    RadiusMapRecord node = radius_maps[first_node];
    while (node.axis != RADIUS_MAP_LEAF)
        node = radius_maps[first_node + (p[node.axis] < node.plane ? node.left : node.right)];
    return radius_maps[first_leaf + node.left];
}

/// RadiusMap::radius_m() of the map with those first records.
float radius_by_map(uint first_node, uint first_leaf, vec3 p, uint turn) {
    const RadiusMapRecord leaf = radius_leaf_at(first_node, first_leaf, p);
    const uvec3 width_m = uvec3(leaf.axis, leaf.left, leaf.right);
    vec3 moved = p;
    uint bits = turn;
    for (int axis = 0; axis < 3; ++axis) {
        bits = hash32(bits + 0x9e3779b9u);
        moved[axis] += uintBitsToFloat(width_m[axis]) * (to_unit_float(bits) - 0.5);
    }
    return radius_leaf_at(first_node, first_leaf, moved).plane;
}

#endif

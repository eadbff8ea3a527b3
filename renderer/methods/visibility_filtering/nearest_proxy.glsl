// What of a voxel lies nearest to a place. Define VISIBILITY (the VisibilityConstants) before, and include hash_grid.glsl
// with the grid's bindings.
#ifndef PHOTOND_NEAREST_PROXY_GLSL
#define PHOTOND_NEAREST_PROXY_GLSL

#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"

/// Whether the nearest of the voxel's proxies has light, seen along the direction.
bool is_lit_at(uint slot, vec3 place, vec3 direction) {
    const uint end = grid_starts[VISIBILITY.grid.first_start + slot + 1];
    float nearest_sq = INFINITY;
    bool is_lit_one = false;
    for (uint i = grid_starts[VISIBILITY.grid.first_start + slot]; i < end; ++i) {
        const vec3 offset = uintBitsToFloat(grid_places[i].xyz) - place;
        if (grid_places[i].w == NO_PROXY || !(dot(offset, offset) < nearest_sq)) continue;
        nearest_sq = dot(offset, offset);
        is_lit_one = proxy_is_lit(grid_places[i].w) && dot(proxy_normal(grid_places[i].w), direction) < 0.0;
    }
    return is_lit_one;
}

#endif

#version 460
// By a voxel octree of the scene's triangles, which is finer than the proxies' voxels.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define FIRST_VOXEL first_set_voxel
#define SVO_CONSTANTS_BINDING 5
#define SVO_NODES_BINDING 6
#define SVO_BRICKS_BINDING 7
#define GRID_STARTS_BINDING 8
#define GRID_PLACES_BINDING 9
#include "renderer/photons/hash_grid.glsl"
#include "renderer/voxels/svo_march.glsl"

bool first_set_voxel(vec3 origin, vec3 normal, vec3 direction, out uint slot, out bool where_lit);

#include "renderer/methods/visibility_filtering/march.glsl"

/// Whether the nearest of the voxel's proxies has light, seen along the direction.
bool is_lit_at(uint slot, vec3 place, vec3 direction) {
    const uint end = grid_starts[constants.grid.first_start + slot + 1];
    float nearest_sq = INFINITY;
    bool is_lit_one = false;
    for (uint i = grid_starts[constants.grid.first_start + slot]; i < end; ++i) {
        const vec3 offset = uintBitsToFloat(grid_places[i].xyz) - place;
        if (grid_places[i].w == NO_PROXY || !(dot(offset, offset) < nearest_sq)) continue;
        nearest_sq = dot(offset, offset);
        is_lit_one = proxy_is_lit(grid_places[i].w) && dot(proxy_normal(grid_places[i].w), direction) < 0.0;
    }
    return is_lit_one;
}

bool first_set_voxel(vec3 origin, vec3 normal, vec3 direction, out uint slot, out bool where_lit) {
    float t;
    uvec3 voxel;
    uint surface;
    slot = 0u;
    where_lit = false;
    const vec3 lifted = svo_lift(origin, normal);
    if (!svo_first_voxel(Ray(lifted, direction, INFINITY), t, voxel, surface)) return false;
    const vec3 place = lifted + (t + 0.5 * svo_constants.grid.cell_m) * direction;
    slot = grid_slot_of(constants.grid, place);
    if (LISTS == LISTS_COUNTS) where_lit = is_lit_at(slot, place, direction);
    return true;
}

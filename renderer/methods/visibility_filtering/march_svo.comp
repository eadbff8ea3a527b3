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
#include "renderer/methods/visibility_filtering/met_voxel.glsl"
#include "renderer/photons/hash_grid.glsl"
#include "renderer/voxels/svo_march.glsl"

bool first_set_voxel(vec3 origin, vec3 normal, vec3 direction, out MetVoxel met);

#include "renderer/methods/visibility_filtering/march.glsl"
#include "renderer/methods/visibility_filtering/nearest_proxy.glsl"

bool first_set_voxel(vec3 origin, vec3 normal, vec3 direction, out MetVoxel met) {
    float t;
    uvec3 voxel;
    uint surface;
    met = MetVoxel(0u, false, vec3(INFINITY));
    const vec3 lifted = svo_lift(origin, normal);
    if (!svo_first_voxel(Ray(lifted, direction, INFINITY), t, voxel, surface)) return false;
    met.place = lifted + (t + 0.5 * svo_constants.grid.cell_m) * direction;
    met.slot = grid_slot_of(constants.grid, met.place);
    if (LISTS == LISTS_COUNTS) met.where_lit = is_lit_at(met.slot, met.place, direction);
    return true;
}

#version 460
// By a voxel octree of the scene's triangles, which is finer than the proxies' voxels.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define FIRST_VOXEL first_set_voxel
#define SVO_CONSTANTS_BINDING 5
#define SVO_NODES_BINDING 6
#define SVO_BRICKS_BINDING 7
#include "renderer/photons/hash_grid.glsl"
#include "renderer/voxels/svo_march.glsl"

bool first_set_voxel(vec3 origin, vec3 normal, vec3 direction, out uint slot);

#include "renderer/methods/visibility_filtering/march.glsl"

bool first_set_voxel(vec3 origin, vec3 normal, vec3 direction, out uint slot) {
    float t;
    uvec3 voxel;
    uint surface;
    slot = 0u;
    const vec3 lifted = svo_lift(origin, normal);
    if (!svo_first_voxel(Ray(lifted, direction, INFINITY), t, voxel, surface)) return false;
    slot = grid_slot_of(constants.grid, lifted + (t + 0.5 * svo_constants.grid.cell_m) * direction);
    return true;
}

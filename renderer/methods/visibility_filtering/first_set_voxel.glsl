// By a voxel octree of the scene's triangles, which is finer than the proxies' voxels. Define VISIBILITY (the
// VisibilityConstants) and LISTS before, and include svo_march.glsl, hash_grid.glsl with the grid's bindings, and
// met_voxel.glsl.
#ifndef PHOTOND_FIRST_SET_VOXEL_GLSL
#define PHOTOND_FIRST_SET_VOXEL_GLSL

#include "renderer/methods/visibility_filtering/nearest_proxy.glsl"

bool first_set_voxel(vec3 origin, vec3 normal, vec3 direction, out MetVoxel met) {
    float t;
    uvec3 voxel;
    uint surface;
    met = MetVoxel(0u, false, NO_PLACE);
    const vec3 lifted = svo_lift(origin, normal);
    if (!svo_first_voxel(Ray(lifted, direction, INFINITY), t, voxel, surface)) return false;
    met.place = lifted + (t + 0.5 * svo_constants.grid.cell_m) * direction;
    met.slot = grid_slot_of(VISIBILITY.grid, met.place);
    if (LISTS == LISTS_COUNTS) met.where_lit = is_lit_at(met.slot, met.place, direction);
    return true;
}

#endif

// GLSL twin of voxels/voxel_grid.h: world positions as whole numbers of 1/256 voxel, the same ones.
#ifndef PHOTOND_VOXEL_GRID_GLSL
#define PHOTOND_VOXEL_GRID_GLSL

#include "renderer/backends/gpu/scene.glsl"
#include "renderer/voxels/svo_shared.h"

vec3 voxel_world_position(uint instance, vec3 p) {
    if (!is_transformed(instance)) return p;
    const mat4x3 m = scene_instances[instance].to_world;
    precise const vec3 world = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    return world;
}

ivec3 quantise(SvoConstants constants, vec3 position) {
    const float kFarUnits = 524288.0;
    precise const vec3 at = (position - constants.grid.low) * constants.units_per_m;
    precise const vec3 nearest = clamp(at, -kFarUnits, kFarUnits) + 0.5;
    return ivec3(floor(nearest));
}

struct QuantisedTriangle {
    ivec3 p[3];
};
QuantisedTriangle quantised_triangle(SvoConstants constants, uint instance, uint triangle) {
    const uint mesh = mesh_of(instance);
    const uvec3 corner = scene_meshes[mesh].first_vertex + triangle_corners(mesh, triangle);
    QuantisedTriangle quantised;
    quantised.p[0] = quantise(constants, voxel_world_position(instance, scene_positions[corner.x]));
    quantised.p[1] = quantise(constants, voxel_world_position(instance, scene_positions[corner.y]));
    quantised.p[2] = quantise(constants, voxel_world_position(instance, scene_positions[corner.z]));
    return quantised;
}

bool is_voxelised(uint instance) {
    if (!NEEDS_ALPHA) return true;
    const uint material = material_of(instance), mode = scene_materials[material].alpha_mode;
    const float alpha = scene_materials[material].alpha;
    if (mode == ALPHA_MASK) return alpha >= scene_materials[material].alpha_cutoff;
    return mode != ALPHA_BLEND || alpha >= 0.5;
}

#endif

#version 460
// By a voxel octree of the scene's triangles.
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
#include "renderer/methods/visibility_filtering/first_set_voxel.glsl"

#version 460
// By the proxies' discs.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define FIRST_VOXEL first_disc
#define GRID_STARTS_BINDING 7
#define GRID_PLACES_BINDING 8
#include "renderer/methods/visibility_filtering/met_voxel.glsl"
#include "renderer/photons/hash_grid.glsl"

bool first_disc(vec3 origin, vec3 normal, vec3 direction, out MetVoxel met);

#include "renderer/methods/visibility_filtering/kept_lists.glsl"
#include "renderer/methods/visibility_filtering/first_disc.glsl"

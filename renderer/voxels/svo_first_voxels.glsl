// How many voxels come before each brick. Define `push`, an SvoBuildPush, before.
#ifndef PHOTOND_SVO_FIRST_VOXELS_GLSL
#define PHOTOND_SVO_FIRST_VOXELS_GLSL

#include "renderer/voxels/svo_build.glsl"

layout(set = 0, binding = 5, scalar) readonly buffer Bricks { SvoBrick bricks[]; };
layout(set = 0, binding = 6, scalar) readonly buffer FirstVoxels { uint first_voxels[]; };
layout(set = 0, binding = 7, scalar) readonly buffer VoxelStarts { uint voxel_starts[]; };
layout(set = 0, binding = 8, scalar) buffer Surfaces { uint surfaces[]; };

uint brick_count() { return min(state.bricks, push.brick_capacity); }
uint first_voxel(uint brick) { return first_voxels[brick] + voxel_starts[brick / push.sum_group]; }
/// Where a brick's triangles begin.
uint first_surface(uint brick) { return brick_count() + first_voxel(brick); }

#endif

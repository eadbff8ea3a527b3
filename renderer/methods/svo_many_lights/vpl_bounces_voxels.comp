#version 460
// The light paths of virtual point lights, whose hits after the first are found in the voxel tree.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/vpl_tracer_shared.h"
#define SVO_CONSTANTS_BINDING VPL_BOUNCE_BINDING
#define SVO_NODES_BINDING VPL_BOUNCE_BINDING + 1
#define SVO_BRICKS_BINDING VPL_BOUNCE_BINDING + 2
#define SVO_SURFACES_BINDING VPL_BOUNCE_BINDING + 3
#define SVO_FIRST_TRIANGLES_BINDING VPL_BOUNCE_BINDING + 4
#include "renderer/voxels/svo_hit.glsl"

#define PHOTON_LATER_HIT svo_closest_hit
#include "renderer/many_lights/vpl_paths.glsl"

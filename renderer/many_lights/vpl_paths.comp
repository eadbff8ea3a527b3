#version 460
// The light paths of virtual point lights, all of whose hits are found by rays.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/vpl_paths.glsl"

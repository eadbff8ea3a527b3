#version 460
// Points lit by virtual point lights, V by the voxels between: vpl_lighting_sum.glsl.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/vpl_lighting_bindings.glsl"
#include "renderer/methods/vpl_visibility_svo.glsl"
#include "renderer/methods/vpl_lighting_sum.glsl"

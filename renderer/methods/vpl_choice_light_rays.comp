#version 460
// Points lit by the lights chosen for them, V by rays: vpl_choice_light.glsl.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/vpl_choice_bindings.glsl"
#include "renderer/methods/vpl_visibility_rays.glsl"
#include "renderer/methods/vpl_choice_light.glsl"

#version 460
// Points lit by virtual point lights, all of which are seen: vpl_choice_light.glsl.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/vpl_choice_bindings.glsl"
#include "renderer/methods/vpl_visibility_none.glsl"
#include "renderer/methods/vpl_choice_light.glsl"

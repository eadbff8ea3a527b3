#version 460
// Direct light and one visible point a pixel, a thread a pixel. The point is written to its place in the split buffer.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/gbuffer/gbuffer_walk.glsl"

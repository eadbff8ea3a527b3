#version 460
// The depth maps of punctual lights say what they light, as in the paper; rays what others do.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#define LIGHT_DEPTH_CONSTANTS_BINDING 7
#define LIGHT_DEPTH_MAPS_BINDING 8
#define LIGHT_DEPTHS_BINDING 9
#include "renderer/gbuffer/light_depth_seen.glsl"

#define PROXY_LIGHT_SEEN(position, normal, source) light_seen_in_map(position, normal, source, hash32(push.pass))
#include "renderer/methods/visibility_filtering/proxy_places.glsl"

#version 460
// Shadow rays say what lights proxies.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "renderer/transport/light_seen.glsl"

#define PROXY_LIGHT_SEEN(position, normal, source) LIGHT_SEEN_UNKNOWN
#include "renderer/methods/visibility_filtering/proxy_places.glsl"

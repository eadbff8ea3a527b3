#version 460
// gbuffer_walk.comp with the shadows of punctual lights from their depth maps.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define LIGHT_DEPTH_CONSTANTS_BINDING 6
#define LIGHT_DEPTH_MAPS_BINDING 7
#define LIGHT_DEPTHS_BINDING 8
#include "renderer/gbuffer/light_depth_seen.glsl"

#define WALK_LIGHT_SEEN(position, normal, source, key) light_seen_in_map(position, normal, source, pixel_key(pass_sampler.pass))
#include "renderer/gbuffer/gbuffer_walk.glsl"

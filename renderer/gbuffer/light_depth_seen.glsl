// A light's depth map as an answer to whether it is seen. Bindings as light_depth_maps.glsl asks.
#ifndef PHOTOND_LIGHT_DEPTH_SEEN_GLSL
#define PHOTOND_LIGHT_DEPTH_SEEN_GLSL

#include "renderer/gbuffer/light_depth_maps.glsl"
#include "renderer/transport/light_seen.glsl"

/// A LIGHT_SEEN_* of a light source; `normal`: geometric, of either side.
uint light_seen_in_map(vec3 position, vec3 normal, uint source, uint pass_key) {
    if (!light_depth_known(source)) return LIGHT_SEEN_UNKNOWN;
    const vec2 u = light_depth_tap_number(position, source, pass_key);
    return light_depth_lit(source, position, normal, u) ? LIGHT_SEEN_WHOLE : LIGHT_SEEN_NOTHING;
}

#endif

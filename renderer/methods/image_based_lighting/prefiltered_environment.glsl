// GLSL twin of PrefilteredEnvironment. Define PREFILTER_CONSTANTS_BINDING and PREFILTER_NODES_BINDING (of set 0) before.
#ifndef PHOTOND_PREFILTERED_ENVIRONMENT_GLSL
#define PHOTOND_PREFILTERED_ENVIRONMENT_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/methods/image_based_lighting/prefiltered_environment_shared.h"
#include "renderer/transport/light_sampling.glsl"

layout(set = 0, binding = PREFILTER_CONSTANTS_BINDING, scalar) readonly buffer Prefilter {
    PrefilterConstants prefilter;
};
layout(set = 0, binding = PREFILTER_NODES_BINDING, scalar) readonly buffer PrefilterNodes { vec3 prefilter_nodes[]; };

/// A place in the unit square.
vec2 octahedral_place(vec3 direction) {
    const vec3 size = abs(direction);
    const vec2 p = direction.xy / (size.x + size.y + size.z);
    const vec2 folded = vec2(copysign(1.0 - abs(p.y), p.x), copysign(1.0 - abs(p.x), p.y));
    return 0.5 * (direction.z < 0.0 ? folded : p) + 0.5;
}

vec3 prefiltered_at(uint map, vec3 direction) {
    const PrefilterLevel level = prefilter.level[map];
    const vec2 place = octahedral_place(direction) * float(level.side);
    const uvec2 cell = min(uvec2(place), uvec2(level.side - 1u));
    const vec2 within = place - vec2(cell);
    const uint above = level.first + cell.y * (level.side + 1u) + cell.x, below = above + level.side + 1u;
    return mix(mix(prefilter_nodes[above], prefilter_nodes[above + 1u], within.x),
               mix(prefilter_nodes[below], prefilter_nodes[below + 1u], within.x), within.y);
}

vec3 prefiltered_radiance(vec3 direction, float roughness) {
    if (roughness <= prefilter.least_roughness)
        return mix(environment_radiance(direction), prefiltered_at(0u, direction),
                   roughness / prefilter.least_roughness);
    const float last = float(prefilter.levels - 1u);
    const float level = clamp(last * (1.0 - log(roughness) / log(prefilter.least_roughness)), 0.0, last);
    const uint sharper = min(uint(level), prefilter.levels - 2u);
    return mix(prefiltered_at(sharper, direction), prefiltered_at(sharper + 1u, direction), level - float(sharper));
}

/// What a white Lambert reflector makes of it: irradiance over pi.
vec3 prefiltered_by_white(vec3 normal) { return prefiltered_at(prefilter.levels - 1u, normal); }

#endif

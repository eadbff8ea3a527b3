// GLSL twin of many_lights/vpl_shadow_maps.h. Before it is included, for vpl_map_occluded(): define VPL_MAPS_BINDING, of
// set 0, the buffer VplShadowMapsGpu::reach().
#ifndef PHOTOND_VPL_SHADOW_MAPS_GLSL
#define PHOTOND_VPL_SHADOW_MAPS_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/many_lights/vpl_shadow_maps_shared.h"

const float VPL_MAP_MOST_STRETCH = 4.0;
const float VPL_MAP_TOLERANCE = 0.25;

/// The unit direction, local to the light's frame, of a place in the map, [0, 1]^2.
vec3 vpl_map_direction(vec2 place) {
    const vec2 e = 2.0 * place - 1.0;
    const float x = 0.5 * (e.x + e.y), y = 0.5 * (e.x - e.y);
    return normalize(vec3(x, y, 1.0 - abs(x) - abs(y)));
}

/// Its inverse, for local vectors of any length but 0 with z >= 0.
vec2 vpl_map_place(vec3 local) {
    const vec2 p = local.xy / (abs(local.x) + abs(local.y) + local.z);
    return 0.5 * vec2(p.x + p.y, p.x - p.y) + 0.5;
}

/// Row after row.
uint vpl_map_texel(vec2 place, uint resolution) {
    const float side = float(resolution);
    const uvec2 at = uvec2(clamp(place * side, 0.0, side - 1.0));
    return at.y * resolution + at.x;
}

/// A texel's centre.
vec3 vpl_map_texel_direction(uint texel, uint resolution) {
    return vpl_map_direction((vec2(texel % resolution, texel / resolution) + 0.5) / float(resolution));
}

/// What a texel holds whose centre's ray meets a surface of that local normal, of either sign, at `distance_m`.
float vpl_map_reach(uint texel, uint resolution, float distance_m, vec3 local_normal) {
    const vec2 low = vec2(texel % resolution, texel / resolution);
    const vec3 centre = vpl_map_direction((low + 0.5) / float(resolution));
    const float cos_centre = dot(local_normal, centre);
    float stretch = 1.0, most_cos = 0.0;
    for (uint i = 0; i < 4; ++i) {
        const vec3 corner = vpl_map_direction((low + vec2(i & 1, i >> 1)) / float(resolution));
        const float ratio = dot(local_normal, corner) / cos_centre;
        stretch = max(stretch, ratio > 1.0 / VPL_MAP_MOST_STRETCH ? 1.0 / ratio : VPL_MAP_MOST_STRETCH);
        most_cos = max(most_cos, 1.0 - dot(corner, centre));
    }
    // Half a diagonal is an angle of sqrt(2 (1 - cos)), a width sqrt(2) times that.
    return distance_m * (stretch + VPL_MAP_TOLERANCE * 2.0 * sqrt(most_cos));
}

#ifdef VPL_MAPS_BINDING

layout(set = 0, binding = VPL_MAPS_BINDING, scalar) readonly buffer VplMaps { float vpl_map_reach_m[]; };

/// Whether light `light`, at `position` with `axes` about its geometric normal, does not reach the point [m]; so too for
/// points behind its surface.
bool vpl_map_occluded(uint light, vec3 position, Frame axes, vec3 point, uint resolution) {
    const vec3 local = to_local(axes, point - position);
    if (!(local.z > 0.0)) return true;
    const uint texel = vpl_map_texel(vpl_map_place(local), resolution);
    return dot(local, local) > sqr(vpl_map_reach_m[light * resolution * resolution + texel]);
}

#endif

#endif

// GLSL twin of what a texel of gbuffer/light_depth_maps.cpp stands for.
#ifndef PHOTOND_LIGHT_DEPTH_MAP_GLSL
#define PHOTOND_LIGHT_DEPTH_MAP_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/gbuffer/light_depth_shared.h"

/// A vector as face `face` of a cube has it: along its axis first. Faces 2 a and 2 a + 1 look along +a and -a.
vec3 light_depth_to_face(vec3 v, uint face) { return face < 2 ? v : face < 4 ? v.yzx : v.zxy; }
vec3 light_depth_from_face(vec3 v, uint face) { return face < 2 ? v : face < 4 ? v.zxy : v.yzx; }

/// The ray through the centre of a map's texel.
Ray light_depth_ray(LightDepthMap map, uint resolution, uint texel) {
    const uint of_face = texel % (resolution * resolution);
    const vec2 across =
        (vec2(of_face % resolution, of_face / resolution) + 0.5) * (2.0 * map.half_side / float(resolution)) - map.half_side;
    if (map.kind == LIGHT_DEPTH_CUBE) {
        const uint face = texel / (resolution * resolution);
        return Ray(map.origin,
                   normalize(light_depth_from_face(vec3(face % 2 == 1 ? -1.0 : 1.0, across), face)), INFINITY);
    }
    const Frame axes = make_frame(map.axis);
    const vec3 aside = across.x * axes.tangent + across.y * axes.bitangent;
    if (map.kind == LIGHT_DEPTH_PARALLEL) return Ray(map.origin + aside, map.axis, INFINITY);
    return Ray(map.origin, normalize(map.axis + aside), INFINITY);
}

#endif

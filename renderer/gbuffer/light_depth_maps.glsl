// GLSL twin of LightDepthMaps::seen(). Define LIGHT_DEPTH_CONSTANTS_BINDING, LIGHT_DEPTH_MAPS_BINDING and
// LIGHT_DEPTHS_BINDING (of set 0) before: LightDepthMapsGpu's buffers.
#ifndef PHOTOND_LIGHT_DEPTH_MAPS_GLSL
#define PHOTOND_LIGHT_DEPTH_MAPS_GLSL

#include "renderer/core/rng.glsl"
#include "renderer/gbuffer/light_depth_map.glsl"

layout(set = 0, binding = LIGHT_DEPTH_CONSTANTS_BINDING, scalar) readonly buffer LightDepthConstantsBuffer {
    LightDepthConstants light_depth_constants;
};
layout(set = 0, binding = LIGHT_DEPTH_MAPS_BINDING, scalar) readonly buffer LightDepthMapsBuffer {
    LightDepthMap light_depth_maps[];
};
layout(set = 0, binding = LIGHT_DEPTHS_BINDING, scalar) readonly buffer LightDepths { float light_depths_m[]; };

/// Where in a map: texels from its corner, and the face of a cube.
struct LightDepthPlace {
    vec2 texel;
    uint face;
};

LightDepthPlace light_depth_place_on_cube(vec3 to_point, float texels_per_unit) {
    const vec3 size = abs(to_point);
    const bool x_first = size.x >= size.y && size.x >= size.z;
    const uint axis = x_first ? 0 : size.y >= size.z ? 1 : 2;
    const float along = x_first ? to_point.x : size.y >= size.z ? to_point.y : to_point.z;
    const uint face = 2 * axis + (along < 0.0 ? 1 : 0);
    return LightDepthPlace((light_depth_to_face(to_point, face).yz / abs(along) + 1.0) * texels_per_unit, face);
}

/// The whole texel within the map; what is no number is at its corner.
uint light_depth_texel_number(float texel) {
    return texel > 0.0 ? uint(min(texel, float(light_depth_constants.resolution - 1))) : 0;
}

/// A texel of the square about the point's place; `width_m`: a texel's at the point.
uint light_depth_choose_texel(LightDepthMap map, vec3 position, vec2 u, out float width_m) {
    const uint resolution = light_depth_constants.resolution;
    const float texels_per_unit = 0.5 * float(resolution) / map.half_side;
    const vec2 aside = (u - 0.5) * light_depth_constants.pcf;
    const vec3 from_origin = position - map.origin;
    LightDepthPlace place = LightDepthPlace(vec2(0.0), 0);
    float dist = 1.0;  // of the plane of the map's texels through the point
    if (map.kind == LIGHT_DEPTH_CUBE) {
        const float size = float(resolution);
        place = light_depth_place_on_cube(from_origin, texels_per_unit);
        place.texel += aside;
        if (!(place.texel.x >= 0.0 && place.texel.x < size && place.texel.y >= 0.0 && place.texel.y < size)) {
            const vec3 to_tap = vec3(place.face % 2 == 1 ? -1.0 : 1.0, place.texel / texels_per_unit - 1.0);
            place = light_depth_place_on_cube(light_depth_from_face(to_tap, place.face), texels_per_unit);
        }
        dist = max(max(abs(from_origin.x), abs(from_origin.y)), abs(from_origin.z));
    } else {
        const vec3 local = to_local(make_frame(map.axis), from_origin);
        if (map.kind == LIGHT_DEPTH_CONE) dist = local.z;
        place.texel = (local.xy / dist + map.half_side) * texels_per_unit + aside;
    }
    width_m = dist / texels_per_unit;
    return (place.face * resolution + light_depth_texel_number(place.texel.y)) * resolution +
           light_depth_texel_number(place.texel.x);
}

/// Whether the light of that number (LightSample::source) has a map: LightSeen::Unknown where it has none.
bool light_depth_known(uint source) {
    return source - light_depth_constants.first_source < light_depth_constants.maps;
}

/// Whether its light reaches the point: LightSeen::Whole, else Nothing.
bool light_depth_lit(uint source, vec3 position, vec3 normal, vec2 u) {
    const LightDepthMap map = light_depth_maps[source - light_depth_constants.first_source];
    float width_m;
    const uint texel = light_depth_choose_texel(map, position, u, width_m);
    const Ray ray = light_depth_ray(map, light_depth_constants.resolution, texel);
    const vec3 to_point = position - ray.origin;
    const float along = dot(to_point, ray.direction);
    const float across = length(to_point - along * ray.direction), farthest = along + LIGHT_DEPTH_MOST_SLOPE * across;
    const float plane = dot(to_point, normal) / dot(ray.direction, normal);
    const float limit =
        (plane > 0.0 && plane < farthest ? plane : farthest) - width_m - LIGHT_DEPTH_CONCAVE_SLOPE * across;
    return light_depths_m[map.first_texel + texel] >= limit;
}

/// LightDepthMaps::tap_number().
vec2 light_depth_tap_number(vec3 position, uint source, uint pass_key) {
    const uvec3 bits = floatBitsToUint(position);
    const uint x = hash32(hash32(hash32(hash32(bits.x) ^ bits.y) ^ bits.z) ^ hash32(source ^ pass_key));
    return vec2(to_unit_float(x), to_unit_float(hash32(x ^ 0x9e3779b9u)));
}

#endif

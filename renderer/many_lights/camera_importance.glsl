// GLSL twin of many_lights/camera_importance.h: which points it looks at, and what light from a place brings to one.
#ifndef PHOTOND_CAMERA_IMPORTANCE_GLSL
#define PHOTOND_CAMERA_IMPORTANCE_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/many_lights/camera_importance_shared.h"
#include "renderer/many_lights/vpl.glsl"

/// The numbers of a pass that draw the points.
RandomStream importance_stream(uint64_t seed, uint pass) {
    return make_random_stream(seed, RANDOM_DOMAIN_SPLATS, pass, uint64_t(CAMERA_IMPORTANCE_STREAM));
}
/// The point of the G-buffer that is the i-th of them.
uint importance_point(RandomStream random, uint i, uint points) {
    random.key += uint64_t(i) * 0x9e3779b97f4a7c15ul;  // a Weyl sequence: any of its numbers comes at once
    return random_stream_next_bits(random) % points;
}

/// The geometric normal on the side that `position` is on.
vec3 importance_side(GBufferPoint point, vec3 position) {
    return dot(point.geometric_normal, position - point.position) > 0.0 ? point.geometric_normal
                                                                        : -point.geometric_normal;
}

/// What flux leaving there brings to the point, over that flux, but for V.
float unshadowed(GBufferPoint point, vec3 position, vec3 normal, float clamp_sq_m2) {
    const vec3 d = point.position - position;
    const float d_sq = dot(d, d);
    if (point.kind == 0u || !(d_sq > 0.0)) return 0.0;
    const vec3 w = d / sqrt(d_sq);
    const float cos_o = dot(normal, w), cos_x = point.normal == vec3(0.0) ? 1.0 : -dot(point.normal, w);
    if (!(cos_o > 0.0 && cos_x > 0.0)) return 0.0;
    const float weight = max_component(point.weight) * ((point.kind & GBUFFER_GENERAL) != 0u ? INV_PI : 1.0);
    return weight * cos_o * cos_x * clamped_falloff(d_sq, clamp_sq_m2);
}

#endif

// GLSL twin of transport/fresnel.h.
#ifndef PHOTOND_FRESNEL_GLSL
#define PHOTOND_FRESNEL_GLSL

#include "renderer/core/geometry.glsl"

/// (1 - cos)^5: how far Schlick's curve has gone from F0 to F90. [Schlick 1994]
float schlick_weight(float cos_theta) {
    const float m = clamp(1.0 - cos_theta, 0.0, 1.0);
    return sqr(sqr(m)) * m;
}

/// Reflectance at normal incidence between media of relative index `eta`.
float normal_reflectance(float eta) { return sqr((eta - 1.0) / (eta + 1.0)); }

/// A dielectric interface met at `cos_o` in (0, 1].
struct DielectricFresnel {
    float reflectance;  // of unpolarised light; 1 under total reflection
    float cos_t;        // > 0: cosine of the refracted direction, measured in its own medium; 0: total reflection
};

/// Exact Fresnel equations. `eta`: index of the far medium over that of wo's medium; 0 reflects everything.
DielectricFresnel fresnel_dielectric(float cos_o, float eta) {
    if (eta == 1.0) return DielectricFresnel(0.0, cos_o);  // no interface, and no rounding that makes one
    if (eta == 0.0) return DielectricFresnel(1.0, 0.0);    // asked by itself: shaders need not keep NaN apart
    const float sin2_t = (1.0 - sqr(cos_o)) / sqr(eta);
    if (sin2_t >= 1.0) return DielectricFresnel(1.0, 0.0);
    const float cos_t = sqrt(1.0 - max(0.0, sin2_t));
    const float parallel = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
    const float perpendicular = (cos_o - eta * cos_t) / (cos_o + eta * cos_t);
    return DielectricFresnel(0.5 * (sqr(parallel) + sqr(perpendicular)), cos_t);
}

/// The direction on the other side of an interface with normal `h` (on wo's side), given the cosines of both sides.
vec3 refract_direction(vec3 wo, vec3 h, float cos_o, float cos_t, float eta) {
    return -wo / eta + (cos_o / eta - cos_t) * h;
}

vec3 reflect_direction(vec3 wo, vec3 h) { return 2.0 * dot(wo, h) * h - wo; }

#endif

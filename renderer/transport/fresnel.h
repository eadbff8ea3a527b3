#pragma once
// Reflectance of interfaces by angle.

#include "renderer/core/rgb.h"

namespace photond {

/// (1 - cos)^5: how far Schlick's curve has gone from F0 to F90. [Schlick 1994]
inline float schlick_weight(float cos_theta) {
    const float m = std::clamp(1.0f - cos_theta, 0.0f, 1.0f);
    return sqr(sqr(m)) * m;
}

/// Reflectance at normal incidence between media of relative index `eta`.
inline float normal_reflectance(float eta) { return sqr((eta - 1.0f) / (eta + 1.0f)); }

/// A dielectric interface met at `cos_o` in (0, 1].
struct DielectricFresnel {
    float reflectance = 1;  // of unpolarised light; 1 under total reflection
    float cos_t = 0;        // > 0: cosine of the refracted direction, measured in its own medium; 0: total reflection
};

/// Exact Fresnel equations. `eta`: index of the far medium over that of wo's medium; 0 reflects everything.
inline DielectricFresnel fresnel_dielectric(float cos_o, float eta) {
    if (eta == 1.0f) return {0.0f, cos_o};  // no interface, and no rounding that makes one
    const float sin2_t = (1.0f - sqr(cos_o)) / sqr(eta);
    if (!(sin2_t < 1.0f)) return {};  // NaN (eta = 0 at normal incidence) too
    const float cos_t = std::sqrt(1.0f - std::max(0.0f, sin2_t));
    const float parallel = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
    const float perpendicular = (cos_o - eta * cos_t) / (cos_o + eta * cos_t);
    return {0.5f * (sqr(parallel) + sqr(perpendicular)), cos_t};
}

/// The direction on the other side of an interface with normal `h` (on wo's side), given the cosines of both sides.
inline vec3 refract_direction(const vec3& wo, const vec3& h, float cos_o, float cos_t, float eta) {
    return -wo / eta + (cos_o / eta - cos_t) * h;
}

inline vec3 reflect_direction(const vec3& wo, const vec3& h) { return 2.0f * glm::dot(wo, h) * h - wo; }

}  // namespace photond

#pragma once
// Maps from uniform numbers in [0, 1)^2 to directions and points, with their densities.

#include <algorithm>

#include "renderer/core/geometry.h"

namespace photond {

/// Area-preserving map of the square to the unit disc, without poles. [Shirley and Chiu 1997] A Low Distortion Map
/// Between Disk and Square.
inline vec2 sample_unit_disk(vec2 u) {
    const float a = 2.0f * u.x - 1.0f, b = 2.0f * u.y - 1.0f;
    const bool wide = std::fabs(a) > std::fabs(b);
    const float radius = wide ? a : b, other = wide ? b : a;
    if (radius == 0.0f) return vec2(0.0f);
    // Angles stay within +-pi/4, where the Taylor series are exact to float precision.
    const float phi = (kPi / 4) * (other / radius), q = phi * phi;
    const float sine = phi * (1 + q * (-1.0f / 6 + q * (1.0f / 120 + q * (-1.0f / 5040 + q * (1.0f / 362880)))));
    const float cosine = 1 + q * (-1.0f / 2 + q * (1.0f / 24 + q * (-1.0f / 720 + q * (1.0f / 40320))));
    return radius * (wide ? vec2(cosine, sine) : vec2(sine, cosine));
}

/// Inverse of sample_unit_disk(), for points of the unit disc.
inline vec2 unit_disk_inverse(const vec2& at) {
    const float radius = glm::length(at);
    if (!(radius > 0)) return vec2(0.5f);
    const bool wide = std::fabs(at.x) > std::fabs(at.y);
    const float along = wide ? at.x : at.y, across = wide ? at.y : at.x;
    const float a = std::copysign(std::min(radius, 1.0f), along), b = a * (4 * kInvPi) * std::atan(across / along);
    return 0.5f * (wide ? vec2(a, b) : vec2(b, a)) + 0.5f;
}

/// Density cos / pi about +z. z > 0 always.
inline vec3 sample_cosine_hemisphere(vec2 u) {
    const vec2 d = sample_unit_disk(u);
    // The floor keeps a direction on the rim out of the surface; it moves directions below 2e-4 of the horizon only.
    return {d.x, d.y, std::sqrt(std::max(1.0f - d.x * d.x - d.y * d.y, 1e-8f))};
}
inline float cosine_hemisphere_pdf(float cos_theta) { return cos_theta > 0 ? cos_theta * kInvPi : 0.0f; }

/// Barycentric weights (of the second and third corner) uniform over a triangle. [Heitz 2019] A Low-Distortion Map
/// Between Triangle and Square.
inline vec2 sample_triangle(vec2 u) {
    if (u.y > u.x) {
        u.x *= 0.5f;
        u.y -= u.x;
    } else {
        u.y *= 0.5f;
        u.x -= u.y;
    }
    return u;
}

}  // namespace photond

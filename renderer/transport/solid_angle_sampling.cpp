#include "renderer/transport/solid_angle_sampling.h"

#include <algorithm>

namespace photond {

namespace {

float sin_from_cos(float c) { return std::sqrt(std::max(0.0f, 1 - c * c)); }

/// Angle between two vectors of any length, accurate when it is small or near pi.
float angle_between(const vec3& a, const vec3& b) { return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)); }

/// The unit vector perpendicular to `axis` (unit) in the half-plane of v.
vec3 unit_perpendicular(const vec3& v, const vec3& axis) { return glm::normalize(v - glm::dot(v, axis) * axis); }

}  // namespace

vec3 sample_spherical_triangle(const vec3& a, const vec3& b, const vec3& c, vec2 u) {
    const vec3 n_ab = glm::cross(a, b), n_bc = glm::cross(b, c), n_ca = glm::cross(c, a);
    const float alpha = angle_between(n_ab, -n_ca);
    const float beta = angle_between(n_bc, -n_ab);
    const float gamma = angle_between(n_ca, -n_bc);

    // A corner c' on the arc a-c such that the triangle a, b, c' has the share u.x of the solid angle.
    const float sub_angles = kPi + u.x * (alpha + beta + gamma - kPi);
    const float cos_alpha = std::cos(alpha), sin_alpha = std::sin(alpha);
    const float sin_phi = std::sin(sub_angles) * cos_alpha - std::cos(sub_angles) * sin_alpha;
    const float cos_phi = std::cos(sub_angles) * cos_alpha + std::sin(sub_angles) * sin_alpha;
    const float k1 = cos_phi + cos_alpha;
    const float k2 = sin_phi - sin_alpha * glm::dot(a, b);
    const float ratio = (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / ((k2 * sin_phi + k1 * cos_phi) * sin_alpha);
    const float cos_arc = ratio >= -1 && ratio <= 1 ? ratio : ratio > 1 ? 1.0f : ratio < -1 ? -1.0f : glm::dot(a, c);
    const vec3 c_sub = cos_arc * a + sin_from_cos(cos_arc) * unit_perpendicular(c, a);

    // A direction on the arc b-c', uniform in solid angle.
    const float cos_theta = 1 - u.y * (1 - glm::dot(c_sub, b));
    return cos_theta * b + sin_from_cos(cos_theta) * unit_perpendicular(c_sub, b);
}

}  // namespace photond

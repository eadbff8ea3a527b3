#pragma once
// Triangles seen from a point: how large they are, and points on them uniform in solid angle.

#include "renderer/core/geometry.h"

namespace photond {

/// Solid angle [sr] of the triangle whose corners lie in the unit directions a, b, c; in [0, 2 pi].
/// [Van Oosterom and Strackee 1983] The Solid Angle of a Plane Triangle. IEEE Trans. Biomed. Eng. 30(2), Eq. 8.
inline float triangle_solid_angle(const vec3& a, const vec3& b, const vec3& c) {
    return 2 *
           std::fabs(std::atan2(glm::dot(a, glm::cross(b, c)), 1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a)));
}

/// A unit direction uniform over the spherical triangle with unit corners a, b, c.
/// Needs a solid angle well above rounding and below a hemisphere: 1e-3 to 6.2 sr.
/// [Arvo 1995] Stratified Sampling of Spherical Triangles. SIGGRAPH; in the form of [Pharr, Jakob, Humphreys 2023],
/// sec. 6.5.4.
vec3 sample_spherical_triangle(const vec3& a, const vec3& b, const vec3& c, vec2 u);

}  // namespace photond

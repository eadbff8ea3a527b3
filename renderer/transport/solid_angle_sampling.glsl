// GLSL twin of transport/solid_angle_sampling.h: how large triangles look, and points on them uniform in solid angle.
#ifndef PHOTOND_SOLID_ANGLE_SAMPLING_GLSL
#define PHOTOND_SOLID_ANGLE_SAMPLING_GLSL

#include "renderer/core/angles.glsl"

/// Solid angle [sr] of the triangle whose corners lie in the unit directions a, b, c; in [0, 2 pi].
/// [Van Oosterom and Strackee 1983, Eq. 8].
float triangle_solid_angle(vec3 a, vec3 b, vec3 c) {
    return 2.0 * abs(atan2(dot(a, cross(b, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a)));
}

/// Angle between two vectors of any length, accurate when it is small or near pi.
float angle_between(vec3 a, vec3 b) { return atan2(length(cross(a, b)), dot(a, b)); }

/// The unit vector perpendicular to `axis` (unit) in the half-plane of v.
vec3 unit_perpendicular(vec3 v, vec3 axis) { return normalize(v - dot(v, axis) * axis); }

/// A unit direction uniform over the spherical triangle with unit corners a, b, c.
/// Needs a solid angle well above rounding and below a hemisphere: 1e-3 to 6.2 sr.
/// [Arvo 1995], in the form of [Pharr, Jakob, Humphreys 2023, sec. 6.5.4].
vec3 sample_spherical_triangle(vec3 a, vec3 b, vec3 c, vec2 u) {
    const vec3 n_ab = cross(a, b), n_bc = cross(b, c), n_ca = cross(c, a);
    const float alpha = angle_between(n_ab, -n_ca);
    const float beta = angle_between(n_bc, -n_ab);
    const float gamma = angle_between(n_ca, -n_bc);

    // A corner c' on the arc a-c such that the triangle a, b, c' has the share u.x of the solid angle.
    const float sub_angles = PI + u.x * (alpha + beta + gamma - PI);
    const vec2 of_alpha = sin_cos(alpha), of_sub_angles = sin_cos(sub_angles);
    const float cos_alpha = of_alpha.y, sin_alpha = of_alpha.x;
    const float sin_phi = of_sub_angles.x * cos_alpha - of_sub_angles.y * sin_alpha;
    const float cos_phi = of_sub_angles.y * cos_alpha + of_sub_angles.x * sin_alpha;
    const float k1 = cos_phi + cos_alpha;
    const float k2 = sin_phi - sin_alpha * dot(a, b);
    const float ratio = (k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / ((k2 * sin_phi + k1 * cos_phi) * sin_alpha);
    const float cos_arc = ratio >= -1.0 && ratio <= 1.0 ? ratio : ratio > 1.0 ? 1.0 : ratio < -1.0 ? -1.0 : dot(a, c);
    const vec3 c_sub = cos_arc * a + sin_from_cos(cos_arc) * unit_perpendicular(c, a);

    // A direction on the arc b-c', uniform in solid angle.
    const float cos_theta = 1.0 - u.y * (1.0 - dot(c_sub, b));
    return cos_theta * b + sin_from_cos(cos_theta) * unit_perpendicular(c_sub, b);
}

#endif

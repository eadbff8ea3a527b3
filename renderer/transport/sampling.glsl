// GLSL twin of transport/sampling.h.
#ifndef PHOTOND_SAMPLING_GLSL
#define PHOTOND_SAMPLING_GLSL

#include "renderer/core/geometry.glsl"

/// Area-preserving map of the square to the unit disc, without poles. [Shirley and Chiu 1997] A Low Distortion Map
/// Between Disk and Square.
vec2 sample_unit_disk(vec2 u) {
    const float a = 2.0 * u.x - 1.0, b = 2.0 * u.y - 1.0;
    const bool wide = abs(a) > abs(b);
    const float radius = wide ? a : b, other = wide ? b : a;
    if (radius == 0.0) return vec2(0.0);
    // Angles stay within +-pi/4, where the Taylor series are exact to float precision.
    const float phi = (PI / 4) * (other / radius), q = phi * phi;
    const float sine = phi * (1 + q * (-1.0 / 6 + q * (1.0 / 120 + q * (-1.0 / 5040 + q * (1.0 / 362880)))));
    const float cosine = 1 + q * (-1.0 / 2 + q * (1.0 / 24 + q * (-1.0 / 720 + q * (1.0 / 40320))));
    return radius * (wide ? vec2(cosine, sine) : vec2(sine, cosine));
}

/// Density cos / pi about +z. z > 0 always.
vec3 sample_cosine_hemisphere(vec2 u) {
    const vec2 d = sample_unit_disk(u);
    // The floor keeps a direction on the rim out of the surface; it moves directions below 2e-4 of the horizon only.
    return vec3(d, sqrt(max(1.0 - d.x * d.x - d.y * d.y, 1e-8)));
}
float cosine_hemisphere_pdf(float cos_theta) { return cos_theta > 0 ? cos_theta * INV_PI : 0.0; }

/// Barycentric weights (of the second and third corner) uniform over a triangle. [Heitz 2019] A Low-Distortion Map
/// Between Triangle and Square.
vec2 sample_triangle(vec2 u) {
    if (u.y > u.x) {
        u.x *= 0.5;
        u.y -= u.x;
    } else {
        u.y *= 0.5;
        u.x -= u.y;
    }
    return u;
}

#endif

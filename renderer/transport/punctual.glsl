// GLSL twin of transport/punctual.h: how far and how wide the lights of KHR_lights_punctual shine.
#ifndef PHOTOND_PUNCTUAL_GLSL
#define PHOTOND_PUNCTUAL_GLSL

#include "renderer/core/angles.glsl"
#include "renderer/transport/light_tables.glsl"

layout(set = SCENE_SET, binding = PUNCTUAL_LIGHTS_BINDING, scalar) readonly buffer PunctualLights {
    PunctualLightRecord punctual_lights[];
};

/// KHR_lights_punctual's window: 1 without a range, falling to 0 at it.
float range_window(float distance_m, float range_m) {
    return range_m < INFINITY ? clamp(1.0 - sqr(sqr(distance_m / range_m)), 0.0, 1.0) : 1.0;
}

/// Share of the intensity left at that cosine of the angle from the axis.
float spot_cone_falloff(PunctualLightRecord light, float cosine) {
    return sqr(clamp((cosine - light.cos_outer) * light.inverse_width, 0.0, 1.0));
}

/// Integral of the falloff over all directions [sr], closed form.
float spot_cone_solid_angle(PunctualLightRecord light) { return 2.0 * PI * (light.plateau + light.ramp); }

/// 1 - cbrt(1 - y) without loss of digits, y in [0, 1].
float cube_root_below_one(float y) {
    const float x = 1.0 - y;
    if (!(x > 0.0)) return 1.0;
    float root = exp2(log2(x) * (1.0 / 3));
    root -= (root - x / (root * root)) * (1.0 / 3);  // Newton's step: exp2 and log2 are not exact on every device
    return y / (1.0 + root + root * root);
}

/// A unit direction about +z with density falloff / solid_angle(); u uniform in [0, 1)^2. Only when that is > 0.
///
/// The host reckons in double; here the distance from the axis in the cosine is written such that float loses nothing:
/// with the ramp's share y = (x - plateau) / ramp within this direction,
///   1 - cos_outer - width top cbrt(1 - y) = plateau + width top (1 - cbrt(1 - y)).
vec3 spot_cone_sample(PunctualLightRecord light, vec2 u) {
    const float x = u.x * (light.plateau + light.ramp);
    float below_one = x;
    if (x >= light.plateau) {
        const float within = clamp((x - light.plateau) / light.ramp, 0.0, 1.0);
        below_one = light.plateau + light.reach * cube_root_below_one(within);
    }
    below_one = clamp(below_one, 0.0, 2.0);
    const float sine = sqrt(below_one * (2.0 - below_one));
    const vec2 azimuth = sin_cos(2.0 * PI * u.y);
    return vec3(sine * azimuth.y, sine * azimuth.x, 1.0 - below_one);
}

#endif

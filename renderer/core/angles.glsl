// Angles and their sines, good to a few units in the last place on every device. GLSL's own need not be: Vulkan lets
// atan be wrong by 4096 units and sin and cos by 2^-11, leaves atan(0, 0) undefined, and drivers make use of it.
// Polynomials of [Moshier 1992] The Cephes Math Library (sinf, cosf, atanf).
#ifndef PHOTOND_ANGLES_GLSL
#define PHOTOND_ANGLES_GLSL

#include "renderer/core/geometry.glsl"

/// std::atan2 of finite numbers; atan2(0, 0) is 0.
float atan2(float y, float x) {
    const float ax = abs(x), ay = abs(y);
    const float low = min(ax, ay), high = max(ax, ay);
    if (high == 0.0) return 0.0;
    // tan(a - pi/4) = (t - 1) / (t + 1): what is left is within +-pi/8.
    const bool wide = low > 0.41421356 * high;
    const float t = wide ? (low - high) / (low + high) : low / high;
    const float z = t * t;
    float angle =
        (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z * t + t;
    if (wide) angle += PI / 4;
    if (ay > ax) angle = PI / 2 - angle;
    if (x < 0.0) angle = PI - angle;
    return copysign(angle, y);
}

/// (sin x, cos x) for |x| up to a few turns.
vec2 sin_cos(float x) {
    const float quarter = roundEven(x * (2.0 / PI));
    // x - quarter pi/2, with pi/2 in three parts, so that nothing of x is lost.
    precise const float rest = ((x - quarter * 1.5703125) - quarter * 4.83751296997e-4) - quarter * 7.54978995489e-8;
    const float z = rest * rest;
    const float s = ((-1.9515295891e-4 * z + 8.3321608736e-3) * z - 1.6666654611e-1) * z * rest + rest;
    const float c = ((2.443315711809948e-5 * z - 1.388731625493765e-3) * z + 4.166664568298827e-2) * z * z - 0.5 * z + 1;
    const int turn = int(quarter) & 3;
    const vec2 both = (turn & 1) == 0 ? vec2(s, c) : vec2(c, s);
    return vec2(turn >= 2 ? -both.x : both.x, turn == 1 || turn == 2 ? -both.y : both.y);
}

float sin_from_cos(float c) { return sqrt(max(0.0, 1.0 - c * c)); }

#endif

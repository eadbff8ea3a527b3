// GLSL twin of methods/photon_splatting/connect_weight.h: what a photon that leaves y brings to a point x its ray passes
// by. The meaning and the derivation are there.
#ifndef PHOTOND_CONNECT_WEIGHT_GLSL
#define PHOTOND_CONNECT_WEIGHT_GLSL

#include "renderer/core/geometry.glsl"

/// Arc sine on [0, 1], to 3e-7. [Abramowitz and Stegun 4.4.46]
float asin_unit(float x) {
    float series = -0.0012624911;
    series = series * x + 0.0066700901;
    series = series * x - 0.0170881256;
    series = series * x + 0.0308918810;
    series = series * x - 0.0501743046;
    series = series * x + 0.0889789874;
    series = series * x - 0.2145988016;
    series = series * x + 1.5707963050;
    return PI / 2 - sqrt(max(1.0 - x, 0.0)) * series;
}

/// F for spheres that the horizon may clip: `h_sq` = H^2 >= 0, `c` in (0, 1]. To 1e-5.
///
/// For H > 1 and H c < 1 (derivations.md, "Splats that connect"), with k2 = 1 - H^2 c^2 and z = sqrt(k2 / (H^2 - 1)):
///   pi P = c acos(-c sqrt((H^2 - 1)/(1 - c^2))) / H^2 - z (H^2 - 1)/H^2 + atan z.
/// Far away (small z) the last two nearly cancel; then atan z - z is summed as a series.
float horizon_factor(float h_sq, float c) {
    if (h_sq <= 1.0) return c / max(h_sq, 1e-30);
    const float k2 = 1.0 - h_sq * c * c;
    if (k2 <= 0) return 1.0;
    const float excess = max(h_sq - 1.0, 1e-12);
    const float z2 = k2 / excess, z = sqrt(z2);
    const float arc = min(c * sqrt(excess / max(1.0 - c * c, 1e-12)), 1.0);
    float rest;  // H^2 (atan z - z) + z, both ways
    if (z2 < 0.16) {
        float series = -1.0 / 15;
        series = series * z2 + 1.0 / 13;
        series = series * z2 - 1.0 / 11;
        series = series * z2 + 1.0 / 9;
        series = series * z2 - 1.0 / 7;
        series = series * z2 + 1.0 / 5;
        series = series * z2 - 1.0 / 3;
        rest = h_sq * z * z2 * series + z;
    } else {
        rest = h_sq * asin_unit(z / sqrt(1.0 + z2)) - sqrt(k2 * excess);
    }
    const float h_sq_pi_p = c * (PI / 2 + asin_unit(arc)) + rest;
    return PI * c / max(h_sq_pi_p, 1e-30);
}

/// F times the clamp with B = `clamp_sq` [m^2] (derivations.md, "The VPL clamp and its exact repayment"): what is left
/// out where d^2 < B is repaid by the receiver. `d_sq` > 0 and `radius_sq` > 0 [m^2].
float connect_factor(float d_sq, float c, float radius_sq, float clamp_sq) {
    const float f = horizon_factor(d_sq * (1 / radius_sq), c);
    return f * min(d_sq * (1 / clamp_sq), 1.0);
}

#endif

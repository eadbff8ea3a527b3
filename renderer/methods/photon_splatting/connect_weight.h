#pragma once
// What a photon that leaves y brings to a point x its ray passes by: the chance of passing, and its inverse
// (derivations.md, "Splats that connect").
//
// A cosine-distributed ray from y passes within r of x with probability P, the form factor of the sphere of radius r
// about x, clipped by y's horizon. With H = d/r, c = cos_y, and where the sphere lies above the horizon (H c >= 1):
// P = c / H^2. A photon that passes brings Phi cos_x cos_y / (pi d^2 P) = Phi cos_x F / (pi r^2),
//   F = c / (H^2 P) for H > 1,   F = c / H^2 for H <= 1 (P = 1),
// so that the mean over its directions is the exact transport from y to x for every r.

#include "renderer/core/lanes.h"

namespace photond {

/// Arc sine on [0, 1], to 3e-7. [Abramowitz and Stegun 4.4.46]
inline FloatLanes asin_lanes(const FloatLanes& x) {
    FloatLanes series = -0.0012624911f;
    for (const float coefficient :
         {0.0066700901f, -0.0170881256f, 0.0308918810f, -0.0501743046f, 0.0889789874f, -0.2145988016f, 1.5707963050f})
        series = series * x + coefficient;
    const FloatLanes root = std::experimental::sqrt(std::experimental::max(1.0f - x, FloatLanes(0)));
    return kPi / 2 - root * series;
}

/// F for spheres that the horizon may clip: `h_sq` = H^2 >= 0, `c` in (0, 1]. To 1e-5.
///
/// For H > 1 and H c < 1 (derivations.md, "Splats that connect"), with k2 = 1 - H^2 c^2 and z = sqrt(k2 / (H^2 - 1)):
///   pi P = c acos(-c sqrt((H^2 - 1)/(1 - c^2))) / H^2 - z (H^2 - 1)/H^2 + atan z.
/// Far away (small z) the last two nearly cancel; then atan z - z is summed as a series.
inline FloatLanes horizon_factor(const FloatLanes& h_sq, const FloatLanes& c) {
    namespace stdx = std::experimental;
    const FloatLanes k2 = 1.0f - h_sq * c * c;
    const FloatLanes excess = stdx::max(h_sq - 1.0f, FloatLanes(1e-12f));
    const FloatLanes z2 = stdx::max(k2, FloatLanes(0)) / excess, z = stdx::sqrt(z2);
    const FloatLanes arc =
        stdx::min(c * stdx::sqrt(excess / stdx::max(1.0f - c * c, FloatLanes(1e-12f))), FloatLanes(1));
    FloatLanes series = -1.0f / 15;
    for (const float coefficient : {1.0f / 13, -1.0f / 11, 1.0f / 9, -1.0f / 7, 1.0f / 5, -1.0f / 3})
        series = series * z2 + coefficient;
    const FloatLanes atan = asin_lanes(z / stdx::sqrt(1.0f + z2));
    // H^2 (atan z - z) + z, both ways.
    const FloatLanes rest =
        select(z2 < 0.16f, h_sq * z * z2 * series + z, h_sq * atan - stdx::sqrt(stdx::max(k2, FloatLanes(0)) * excess));
    const FloatLanes h_sq_pi_p = c * (kPi / 2 + asin_lanes(arc)) + rest;
    const FloatLanes clipped = kPi * c / stdx::max(h_sq_pi_p, FloatLanes(1e-30f));
    return select(h_sq <= 1.0f, c / stdx::max(h_sq, FloatLanes(1e-30f)), select(k2 > 0, clipped, FloatLanes(1)));
}

/// F times the clamp with B = `clamp_sq` [m^2] (derivations.md, "The VPL clamp and its exact repayment"): what is left
/// out where d^2 < B is repaid by the receiver. `d_sq` > 0 and `radius_sq` > 0 [m^2].
inline FloatLanes connect_factor(const FloatLanes& d_sq, const FloatLanes& c, float radius_sq, float clamp_sq) {
    const FloatLanes f = horizon_factor(d_sq * (1 / radius_sq), c);
    return f * std::experimental::min(d_sq * (1 / clamp_sq), FloatLanes(1));
}

}  // namespace photond

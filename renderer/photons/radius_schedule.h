#pragma once
// Radii of density estimates that shrink from pass to pass, so that the mean of the passes converges.
//
// r_i^2 = r_1^2 Gamma(i + alpha) / (Gamma(1 + alpha) Gamma(i + 1)), i = pass index + 1 (derivations.md, "Radius of pass
// i"): a function of the pass alone, so that any pass can be rendered anywhere. [Knaus and Zwicker 2011] Progressive
// Photon Mapping: A Probabilistic Approach. ACM TOG 30(3).

#include <cmath>
#include <cstdint>

namespace photond {

/// Share of the noise that is kept: the mean's variance falls as N^-alpha, its bias as N^(alpha - 1). At two thirds
/// their sum of squares falls fastest.
inline constexpr double kRadiusAlpha = 2.0 / 3;

/// The radius of that pass over the first one's.
inline float radius_share(uint32_t pass, double alpha = kRadiusAlpha) {
    const double i = static_cast<double>(pass) + 1;
    const double squared = std::lgamma(i + alpha) - std::lgamma(1 + alpha) - std::lgamma(i + 1);
    return static_cast<float>(std::exp(0.5 * squared));
}

}  // namespace photond

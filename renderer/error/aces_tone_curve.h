#pragma once
// The tone curve of HDR-FLIP: part of the metric's definition, and so apart from the curves of previews (film).

#include <cmath>

#include "renderer/core/lanes.h"

namespace photond {

/// Narkowicz's fit to ACES with its exposure of 0.6 folded in: a rational function of scene-linear values
/// [Andersson et al. 2021], (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5); the published k2 is 0.
struct AcesToneCurve {
    static constexpr double k0 = 0.6 * 0.6 * 2.51, k1 = 0.6 * 0.03, k3 = 0.6 * 0.6 * 2.43, k4 = 0.6 * 0.59, k5 = 0.14;

    /// Of x >= 0, clamped to [0, 1]. From 12.1 on it is 1, so that large x need not be squared.
    static FloatLanes at(const FloatLanes& x) {
        const FloatLanes t = std::experimental::min(x, FloatLanes(16.0f));
        constexpr auto f = [](double k) { return static_cast<float>(k); };
        constexpr float a = f(k0), b = f(k1), c = f(k3), d = f(k4), e = f(k5);
        return std::experimental::min(t * (a * t + b) / (t * (c * t + d) + e), FloatLanes(1.0f));
    }

    /// The x >= 0 with that value, of values in [0, 1]: the positive root of (k0 - v k3) x^2 + (k1 - v k4) x - v k5.
    static double inverse(double value) {
        const double a = k0 - value * k3, b = k1 - value * k4, c = -value * k5;
        return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
    }
};

}  // namespace photond

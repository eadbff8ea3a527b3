#include "renderer/photons/kernel.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <string>

#include "protocol/error.h"

namespace photond {

namespace {

/// Of the Gaussian: the share of 1 - exp(-beta q^2 / 2) in its shape.
double gaussian_fall(double beta) { return 1 / (1 - std::exp(-beta)); }

/// Mean of function(q^2) over q^2 from 0 to 1, to 1e-5 for kernels: 2 q dq = d(q^2).
template <class Function>
float mean_over_disc(const Function& function) {
    constexpr int kSteps = 512;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += function((i + 0.5) / kSteps);
    return static_cast<float>(sum / kSteps);
}

/// Integral of the Gaussian's shape over q^2 from 0 to t.
double gaussian_integral(double beta, double t) {
    return t - gaussian_fall(beta) * (t - (1 - std::exp(-0.5 * beta * t)) * 2 / beta);
}

/// 1 - (1 + x) exp(-x) for x in [0, 1], as a series, which cancels little.
float one_less_gaussian(float x) {
    constexpr std::array kTerms = {-1.0 / 3991680, 1.0 / 403200, -1.0 / 45360, 1.0 / 5760, -1.0 / 840,
                                   1.0 / 144,      -1.0 / 30,    1.0 / 8,      -1.0 / 3,   1.0 / 2};
    float series = 0;
    for (const double term : kTerms) series = series * x + static_cast<float>(term);
    return x * x * series;
}

}  // namespace

Kernel::Kernel(KernelShape shape, float cone_k) : shape_(shape), cone_k_(cone_k) {
    if (!(cone_k >= 1))
        throw Error(ErrorCode::OutOfRange,
                    "cone_k = " + std::to_string(cone_k) + " is below 1: the cone would turn negative");
    // Over the disc of radius 1, 2 q dq = d(q^2): each shape's integral over q^2 from 0 to 1, times pi, is divided out.
    double scale = 1 / std::numbers::pi, slope = 0;
    switch (shape) {
        case KernelShape::Constant: break;
        case KernelShape::Cone:
            scale = 1 / ((1 - 2 / (3 * double{cone_k})) * std::numbers::pi);
            slope = scale / double{cone_k};
            break;
        case KernelShape::Gaussian:
            scale = 1 / (gaussian_integral(double{kGaussianBeta}, 1) * std::numbers::pi);
            slope = scale * gaussian_fall(double{kGaussianBeta});
            break;
        case KernelShape::Epanechnikov: slope = scale = 2 / std::numbers::pi; break;
    }
    scale_ = static_cast<float>(scale);
    slope_ = static_cast<float>(slope);
}

float Kernel::mass_within(float q) const {
    const double x = std::clamp(double{q}, 0.0, 1.0), k = double{cone_k_}, beta = double{kGaussianBeta};
    double mass = 0;
    switch (shape_) {
        case KernelShape::Constant: mass = x * x; break;
        case KernelShape::Cone: mass = x * x * (1 - 2 * x / (3 * k)) / (1 - 2 / (3 * k)); break;
        case KernelShape::Gaussian: mass = gaussian_integral(beta, x * x) / gaussian_integral(beta, 1); break;
        case KernelShape::Epanechnikov: mass = x * x * (2 - x * x); break;
    }
    return static_cast<float>(mass);
}

float Kernel::mean_q_sq() const {
    return mean_over_disc(
        [this](double q_sq) { return std::numbers::pi * q_sq * double{(*this)(static_cast<float>(q_sq))}; });
}

float Kernel::roughness() const {
    return mean_over_disc([this](double q_sq) {
        const double k = std::numbers::pi * double{(*this)(static_cast<float>(q_sq))};
        return k * k;
    });
}

float Kernel::sample_disc(float u) const {
    u = std::max(u, 0x1p-26f);  // no disc without area; numbers are multiples of 2^-24
    switch (shape_) {
        case KernelShape::Constant: return 1;
        case KernelShape::Cone: return std::min(std::cbrt(3 * u / (kPi * slope_)), 1.0f);
        case KernelShape::Epanechnikov: return std::sqrt(std::sqrt(u));
        case KernelShape::Gaussian: break;
    }
    // Discs up to radius q hold S(q) = integral of -pi t^2 K'(t) over t from 0 to q; of the Gaussian S = pi slope
    // (2 / beta) (1 - (1 + x) exp(-x)) with x = beta q^2 / 2. That is inverted by Newton's method; S is convex here:
    // after the first step, which may pass the end, all come from above.
    const float end = 0.5f * kGaussianBeta, wanted = u * kGaussianBeta / (2 * kPi * slope_);
    float x = std::min(std::sqrt(2 * wanted), end);  // of the first term, x^2 / 2, alone
    for (int i = 0; i < 3; ++i) x = std::min(x + (wanted - one_less_gaussian(x)) / (x * std::exp(-x)), end);
    return std::sqrt(x / end);
}

}  // namespace photond

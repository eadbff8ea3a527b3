#include "renderer/error/flip_filters.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace photond {

namespace {

using Half = std::vector<double>;

double sum_of(const Half& half) {
    double sum = half[0];
    for (size_t k = 1; k < half.size(); ++k) sum += 2 * half[k];
    return sum;
}

HalfFilter scaled(const Half& half, double scale) {
    HalfFilter weights(half.size());
    for (size_t k = 0; k < half.size(); ++k) weights[k] = static_cast<float>(half[k] * scale);
    return weights;
}

/// exp(-pi^2 x^2 / b) at x = k pixels [degrees]: the Fourier transform of a Gaussian contrast sensitivity.
Half contrast_gaussian(double b, double pixels_per_degree, size_t radius) {
    Half half(radius + 1);
    for (size_t k = 0; k <= radius; ++k) {
        const double x = static_cast<double>(k) / pixels_per_degree;
        half[k] = std::exp(-std::numbers::pi * std::numbers::pi * x * x / b);
    }
    return half;
}

/// Without the outer weights that do not show in a float sum.
Half trimmed(Half half) {
    const double negligible = std::ldexp(sum_of(half), -26);
    for (double tail = 0; half.size() > 1; half.pop_back()) {
        tail += 2 * half.back();
        if (tail >= negligible) break;
    }
    return half;
}

// Contrast sensitivity, a Gaussian of scale b [degrees^2 pi^2] for each of the first two channels and two for the third
// [Andersson et al. 2020, Sec. 4.1]. The published a2 = 0 of the first two leaves one.
constexpr double kAchromaticB = 0.0047, kRedGreenB = 0.0053;
constexpr std::array<double, 2> kBlueYellowA{34.1, 13.5}, kBlueYellowB{0.04, 0.025};

/// Three standard deviations of the widest Gaussian, for all.
size_t contrast_radius(double pixels_per_degree) {
    const double deviation = std::sqrt(kBlueYellowB[0] / (2 * std::numbers::pi * std::numbers::pi));  // degrees
    return static_cast<size_t>(std::ceil(3 * deviation * pixels_per_degree));
}

void set_blue_yellow(FlipFilters& filters, double pixels_per_degree, size_t radius) {
    std::array<Half, 2> gaussian;
    std::array<double, 2> amplitude{};
    double sum = 0;  // of the two-dimensional kernel
    for (size_t i = 0; i < 2; ++i) {
        gaussian[i] = contrast_gaussian(kBlueYellowB[i], pixels_per_degree, radius);
        amplitude[i] = kBlueYellowA[i] * std::sqrt(std::numbers::pi / kBlueYellowB[i]);
        sum += amplitude[i] * sum_of(gaussian[i]) * sum_of(gaussian[i]);
    }
    for (size_t i = 0; i < 2; ++i) filters.blue_yellow[i] = scaled(gaussian[i], std::sqrt(amplitude[i] / sum));
}

/// The two signs scaled each to a sum of 1.
HalfFilter normalized_second_derivative(const Half& half) {
    double positive = 0, negative = 0;
    for (size_t k = 0; k < half.size(); ++k) (half[k] > 0 ? positive : negative) += (k == 0 ? 1 : 2) * half[k];
    HalfFilter weights(half.size());
    for (size_t k = 0; k < half.size(); ++k)
        weights[k] = static_cast<float>(half[k] > 0 ? half[k] / positive : -half[k] / negative);
    return weights;
}

void set_detectors(FlipFilters& filters, double pixels_per_degree) {
    constexpr double kPeakToTroughDegrees = 0.082;  // w
    const double deviation = 0.5 * kPeakToTroughDegrees * pixels_per_degree;
    const auto radius = static_cast<size_t>(std::ceil(3 * deviation));
    Half gaussian(radius + 1), first(radius + 1), second(radius + 1);
    double first_sum = 0;
    for (size_t k = 0; k <= radius; ++k) {
        const double x = static_cast<double>(k) / deviation;
        gaussian[k] = std::exp(-0.5 * x * x);
        first[k] = x * gaussian[k];
        second[k] = (x * x - 1) * gaussian[k];
        first_sum += first[k];
    }
    filters.gaussian = scaled(gaussian, 1 / sum_of(gaussian));
    filters.edge = scaled(first, 1 / first_sum);
    filters.point = normalized_second_derivative(second);
}

}  // namespace

FlipFilters make_flip_filters(double pixels_per_degree) {
    assert(pixels_per_degree >= 1 && "FLIP: pixels per degree");
    FlipFilters filters;
    const size_t radius = contrast_radius(pixels_per_degree);
    const Half achromatic = trimmed(contrast_gaussian(kAchromaticB, pixels_per_degree, radius));
    const Half red_green = trimmed(contrast_gaussian(kRedGreenB, pixels_per_degree, radius));
    filters.achromatic = scaled(achromatic, 1 / sum_of(achromatic));
    filters.red_green = scaled(red_green, 1 / sum_of(red_green));
    set_blue_yellow(filters, pixels_per_degree, radius);
    set_detectors(filters, pixels_per_degree);
    filters.radius = std::max(filters.blue_yellow[0].size(), filters.gaussian.size()) - 1;
    return filters;
}

}  // namespace photond

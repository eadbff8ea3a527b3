#include "renderer/error/student_t.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace photond {

namespace {

constexpr double kNormalDegrees = 1e8;  // from there on tails are those of the normal distribution to 1e-7

/// The regularised incomplete beta function I_x(a, b), y = 1 - x: [Abramowitz and Stegun 1964, 26.5.8], a continued
/// fraction, which converges fast for x below (a + 1) / (a + b + 2); above, I_x(a, b) = 1 - I_y(b, a).
double incomplete_beta(double a, double b, double x, double y) {
    if (x <= 0) return 0;
    if (x > (a + 1) / (a + b + 2)) return 1 - incomplete_beta(b, a, y, x);
    // By its convergents' numerators and denominators; both are scaled by the latest denominator.
    double numerator = 1, denominator = 1, earlier_numerator = 1, earlier_denominator = 0, fraction = 0;
    for (int m = 0; m < 100'000; ++m) {
        const double n = a + 2 * m;
        const double odd = -(a + m) * (a + b + m) / (n * (n + 1)) * x;
        const double even = (m + 1) * (b - m - 1) / ((n + 1) * (n + 2)) * x;
        for (const double coefficient : {odd, even}) {
            const double next_numerator = numerator + coefficient * earlier_numerator;
            const double next_denominator = denominator + coefficient * earlier_denominator;
            earlier_numerator = numerator / next_denominator, earlier_denominator = denominator / next_denominator;
            numerator = next_numerator / next_denominator, denominator = 1;
        }
        const double before = fraction;
        fraction = numerator;
        if (std::fabs(fraction - before) <= 1e-16 * fraction) break;
    }
    const double log_beta = std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b);
    return std::exp(a * std::log(x) + b * std::log(y) - log_beta) / (a * fraction);
}

}  // namespace

double student_t_tails(double t, double degrees) {
    assert(degrees > 0);
    if (degrees >= kNormalDegrees) return std::erfc(std::fabs(t) / std::numbers::sqrt2);
    const double square = t * t, sum = degrees + square;
    if (std::isinf(sum)) return 0;
    return incomplete_beta(0.5 * degrees, 0.5, degrees / sum, square / sum);
}

double two_sided_student_t(double probability, double degrees) {
    assert(probability >= 0 && probability < 1);
    // Bisection on the angle whose tangent is t over a scale.
    const double scale = std::sqrt(std::min(degrees, kNormalDegrees)), outside = 1 - probability;
    double low = 0, high = std::numbers::pi / 2;
    for (int i = 0; i < 64; ++i) {
        const double angle = 0.5 * (low + high);
        (student_t_tails(scale * std::tan(angle), degrees) > outside ? low : high) = angle;
    }
    return scale * std::tan(low);
}

}  // namespace photond

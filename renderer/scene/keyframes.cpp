#include "renderer/scene/keyframes.h"

#include <algorithm>
#include <cmath>

namespace photond {

namespace {

void normalize_quaternion(double* q) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (length > 0)
        for (int k = 0; k < 4; ++k) q[k] /= length;
}

/// Appendix C.4, of unit quaternions: along the shorter of the two arcs.
void slerp(const double* a, const double* b, double t, double* result) {
    double dot = 0;
    for (int k = 0; k < 4; ++k) dot += a[k] * b[k];
    const double angle = std::acos(std::min(std::fabs(dot), 1.0)), sine = std::sin(angle);
    // Of so small an angle sines say nothing more than the numbers themselves.
    const bool straight = !(sine > 1e-9);
    const double from = straight ? 1 - t : std::sin(angle * (1 - t)) / sine;
    const double to = (straight ? t : std::sin(angle * t) / sine) * (dot < 0 ? -1 : 1);
    for (int k = 0; k < 4; ++k) result[k] = from * a[k] + to * b[k];
}

}  // namespace

void Keyframes::evaluate(double time_s, double* result) const {
    const bool spline = interpolation == Interpolation::CubicSpline;
    const size_t numbers = size_t{width} * (spline ? 3 : 1);  // of a key
    const auto value_of = [&](size_t key) { return &values[key * numbers + (spline ? width : 0)]; };
    const auto copy = [&](size_t key, double* to) {
        std::transform(value_of(key), value_of(key) + width, to, [](float x) { return static_cast<double>(x); });
        if (rotation) normalize_quaternion(to);
    };

    const auto after = std::upper_bound(times.begin(), times.end(), time_s,
                                        [](double time, float key) { return time < static_cast<double>(key); });
    if (after == times.begin()) return copy(0, result);
    const auto key = static_cast<size_t>(after - times.begin()) - 1;
    if (after == times.end() || interpolation == Interpolation::Step) return copy(key, result);

    const double length = static_cast<double>(times[key + 1]) - static_cast<double>(times[key]);
    const double t = (time_s - static_cast<double>(times[key])) / length;
    if (spline) {
        // Appendix C.5. Tangents are a second's, whatever the length of the interval.
        const float *from = value_of(key), *to = value_of(key + 1);
        const double t2 = t * t, t3 = t2 * t;
        for (size_t k = 0; k < width; ++k) {
            const double out = length * static_cast<double>(from[k + width]);
            const double in = length * static_cast<double>(*(to + k - width));
            result[k] = (2 * t3 - 3 * t2 + 1) * static_cast<double>(from[k]) + (t3 - 2 * t2 + t) * out +
                        (-2 * t3 + 3 * t2) * static_cast<double>(to[k]) + (t3 - t2) * in;
        }
        if (rotation) normalize_quaternion(result);
    } else if (rotation) {
        double a[4], b[4];
        copy(key, a), copy(key + 1, b);
        slerp(a, b, t, result);
        normalize_quaternion(result);
    } else {
        for (size_t k = 0; k < width; ++k)
            result[k] = (1 - t) * static_cast<double>(value_of(key)[k]) + t * static_cast<double>(value_of(key + 1)[k]);
    }
}

}  // namespace photond

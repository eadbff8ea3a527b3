#include "renderer/error/curve.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>

namespace photond {

namespace {

bool positive(double x) { return x > 0 && std::isfinite(x); }

/// Linear interpolation of log y over log x between two points with x0 < x1.
double log_log_interpolated(double x0, double y0, double x1, double y1, double x) {
    return y0 * std::pow(y1 / y0, std::log(x / x0) / std::log(x1 / x0));
}

/// P(|T| < sqrt(degrees) tan(theta)) for Student's t with a whole number of degrees >= 1; theta in [0, pi/2).
/// [Abramowitz and Stegun 1964] Handbook of Mathematical Functions, 26.7.3 and 26.7.4: finite sums.
double student_t_inside(double theta, uint64_t degrees) {
    const double cosine = std::cos(theta), sine = std::sin(theta);
    const bool odd = degrees % 2 == 1;
    if (degrees == 1) return theta * 2 / std::numbers::pi;
    // Odd: cos + 2/3 cos^3 + 2*4/(3*5) cos^5 ... cos^(degrees-2); even: 1 + 1/2 cos^2 + 1*3/(2*4) cos^4 ... likewise.
    double term = odd ? cosine : 1, sum = term;
    for (uint64_t power = odd ? 3 : 2; power <= degrees - 2; power += 2) {
        term *= cosine * cosine * static_cast<double>(power - 1) / static_cast<double>(power);
        sum += term;
    }
    return odd ? (theta + sine * sum) * 2 / std::numbers::pi : sine * sum;
}

/// The t that |T| stays below with this probability: bisection on the angle, in which student_t_inside() rises.
double two_sided_student_t(double probability, uint64_t degrees) {
    double low = 0, high = std::numbers::pi / 2;
    for (int i = 0; i < 60; ++i) {
        const double theta = 0.5 * (low + high);
        (student_t_inside(theta, degrees) < probability ? low : high) = theta;
    }
    return std::sqrt(static_cast<double>(degrees)) * std::tan(low);
}

}  // namespace

bool CurveSchedule::due(uint32_t passes, double seconds) {
    assert(std::isfinite(seconds));
    const bool due = is_due(passes, seconds);
    skip_to(passes, seconds);
    return due;
}

void CurveSchedule::skip_to(uint32_t passes, double seconds) {
    if (passes >= next_passes_) next_passes_ = std::bit_ceil(uint64_t{passes} + 1);
    // Doubling is exact, so that the marks are those of 0.1 x 2^k however many are passed at once.
    while (next_seconds_ <= seconds && std::isfinite(next_seconds_)) next_seconds_ *= 2;
}

std::vector<TimedError> timed_errors(std::span<const CurvePoint> curve, const std::string& metric) {
    std::vector<TimedError> errors;
    for (const CurvePoint& point : curve) {
        const auto found = point.metrics.find(metric);
        if (found == point.metrics.end() || !found->second) continue;
        if (positive(point.seconds) && positive(*found->second)) errors.push_back({point.seconds, *found->second});
    }
    // Of points that the clock does not tell apart the last stands: it has the most passes.
    std::stable_sort(errors.begin(), errors.end(),
                     [](const TimedError& a, const TimedError& b) { return a.seconds < b.seconds; });
    size_t kept = 0;
    for (size_t i = 0; i < errors.size(); ++i)
        if (i + 1 == errors.size() || errors[i].seconds < errors[i + 1].seconds) errors[kept++] = errors[i];
    errors.resize(kept);
    return errors;
}

std::optional<double> time_to_error(std::span<const TimedError> curve, double error) {
    size_t first = curve.size();  // of the points at the end that are all at or below
    while (first > 0 && curve[first - 1].error <= error) --first;
    if (first == curve.size()) return std::nullopt;
    const TimedError& below = curve[first];
    if (first == 0 || below.error == error) return below.seconds;
    const TimedError& above = curve[first - 1];
    return log_log_interpolated(above.error, above.seconds, below.error, below.seconds, error);
}

std::optional<double> error_at_time(std::span<const TimedError> curve, double seconds) {
    const auto after = std::lower_bound(curve.begin(), curve.end(), seconds,
                                        [](const TimedError& point, double time) { return point.seconds < time; });
    if (after == curve.end()) return std::nullopt;
    if (after->seconds == seconds) return after->error;
    if (after == curve.begin()) return std::nullopt;
    const TimedError& before = *std::prev(after);
    return log_log_interpolated(before.seconds, before.error, after->seconds, after->error, seconds);
}

std::optional<LogMean> log_mean(std::span<const double> values) {
    if (values.empty() || !std::all_of(values.begin(), values.end(), positive)) return std::nullopt;
    const auto count = static_cast<double>(values.size());
    double mean = 0, squares = 0;
    for (const double value : values) mean += std::log(value) / count;
    LogMean result{.mean = std::exp(mean), .low = {}, .high = {}};
    if (values.size() == 1) return result;
    for (const double value : values) squares += (std::log(value) - mean) * (std::log(value) - mean);
    const double half_width = two_sided_student_t(0.95, values.size() - 1) * std::sqrt(squares / (count - 1) / count);
    result.low = std::exp(mean - half_width);
    result.high = std::exp(mean + half_width);
    return result;
}

std::optional<double> log_log_slope(std::span<const double> x, std::span<const double> y) {
    assert(x.size() == y.size());
    if (x.size() < 2 || !std::all_of(x.begin(), x.end(), positive) || !std::all_of(y.begin(), y.end(), positive))
        return std::nullopt;
    if (std::all_of(x.begin(), x.end(), [&](double value) { return value == x[0]; })) return std::nullopt;
    const auto count = static_cast<double>(x.size());
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < x.size(); ++i) mean_x += std::log(x[i]) / count, mean_y += std::log(y[i]) / count;
    for (size_t i = 0; i < x.size(); ++i) {
        const double dx = std::log(x[i]) - mean_x;
        xx += dx * dx;
        xy += dx * (std::log(y[i]) - mean_y);
    }
    return xy / xx;
}

}  // namespace photond

#include "renderer/error/curve.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/error/student_t.h"

namespace photond {

namespace {

bool positive(double x) { return x > 0 && std::isfinite(x); }

double log_share(double from, double to, double at) { return std::log(at / from) / std::log(to / from); }

/// Student's t, of numbers whose mean is known.
double half_width(std::span<const double> values, double mean) {
    const auto count = static_cast<double>(values.size());
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return two_sided_student_t(0.95, count - 1) * std::sqrt(squares / (count - 1) / count);
}

double mean_of(std::span<const double> values) {
    double mean = 0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    return mean;
}

/// The fit to errors that are 0 or above; 0, which has no logarithm, as `zero` or the smallest above 0.
std::vector<double> falling_fit(std::span<const TimedError> curve, double zero) {
    for (const TimedError& point : curve)
        if (point.error > 0) zero = std::min(zero, point.error);
    std::vector<double> errors, logs;
    for (const TimedError& point : curve) errors.push_back(point.error > 0 ? point.error : zero);
    for (const double error : errors) logs.push_back(std::log(error));
    const std::vector<double> fit = non_increasing_fit(logs);
    for (size_t i = 0; i < fit.size(); ++i)
        if (fit[i] != logs[i]) errors[i] = std::exp(fit[i]);
    return errors;
}

/// Where a curve comes down to an error.
struct Crossing {
    size_t point;  // the first of the fit that is at or below
    double seconds;
};

/// `error` is above 0.
std::optional<Crossing> crossing(std::span<const TimedError> curve, double error) {
    const std::vector<double> fit = falling_fit(curve, error);
    const auto found = std::find_if(fit.begin(), fit.end(), [error](double fitted) { return fitted <= error; });
    if (found == fit.end()) return std::nullopt;
    const auto i = static_cast<size_t>(found - fit.begin());
    if (i == 0 || fit[i] == error) return Crossing{i, curve[i].seconds};
    const double share = log_share(fit[i - 1], fit[i], error);
    return Crossing{i, curve[i - 1].seconds * std::pow(curve[i].seconds / curve[i - 1].seconds, share)};
}

/// What each point and the next one are both at most.
std::vector<TimedError> borne_out(std::span<const TimedError> curve) {
    std::vector<TimedError> points;
    for (size_t i = 0; i + 1 < curve.size(); ++i)
        points.push_back({curve[i].seconds, std::max(curve[i].upper_end(), curve[i + 1].upper_end())});
    return points;
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

double TimedError::upper_end() const {
    if (!interval) return error;
    return error > 0 ? interval->greatest : std::max(interval->greatest, 0.5 * (interval->greatest - interval->least));
}

std::optional<TimedError> timed_error(const CurvePoint& point, const std::string& metric) {
    const auto found = point.metrics.find(metric);
    const auto value = found != point.metrics.end() ? found->second : std::nullopt;
    const auto ends = point.intervals.find(metric);
    TimedError error{point.seconds, value.value_or(0)};
    if (ends != point.intervals.end()) error.interval = ends->second;
    const bool shows = value || (error.interval && error.upper_end() > 0);
    return shows && std::isfinite(error.error) ? std::optional(error) : std::nullopt;
}

std::vector<TimedError> timed_errors(std::span<const CurvePoint> curve, const std::string& metric) {
    std::vector<TimedError> errors;
    for (const CurvePoint& point : curve)
        if (const auto error = timed_error(point, metric); error && positive(error->seconds)) errors.push_back(*error);
    // Of points that the clock does not tell apart the last stands: it has the most passes.
    std::stable_sort(errors.begin(), errors.end(),
                     [](const TimedError& a, const TimedError& b) { return a.seconds < b.seconds; });
    size_t kept = 0;
    for (size_t i = 0; i < errors.size(); ++i)
        if (i + 1 == errors.size() || errors[i].seconds < errors[i + 1].seconds) errors[kept++] = errors[i];
    errors.resize(kept);
    return errors;
}

std::vector<double> non_increasing_fit(std::span<const double> values) {
    struct Pool {
        double mean;
        size_t count;
    };
    std::vector<Pool> pools;
    for (const double value : values) {
        pools.push_back({value, 1});
        while (pools.size() > 1 && pools.back().mean > pools[pools.size() - 2].mean) {
            const Pool last = pools.back();
            pools.pop_back();
            Pool& before = pools.back();
            before.count += last.count;
            before.mean +=
                (last.mean - before.mean) * static_cast<double>(last.count) / static_cast<double>(before.count);
        }
    }
    std::vector<double> fit;
    for (const Pool& pool : pools) fit.insert(fit.end(), pool.count, pool.mean);
    return fit;
}

std::optional<double> time_to_error(std::span<const TimedError> curve, double error) {
    if (!(error > 0)) return std::nullopt;
    const auto reached = crossing(borne_out(curve), error);
    return reached ? std::optional(reached->seconds) : std::nullopt;
}

std::optional<Interval> errors_reached(std::span<const TimedError> curve) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const std::vector<double> fit = falling_fit(borne_out(curve), kNone);
    if (fit.empty() || fit.front() == kNone) return std::nullopt;
    return Interval{fit.back(), fit.front()};
}

std::optional<double> earliest_time_to_error(std::span<const TimedError> curve, double error) {
    if (!(error > 0)) return std::nullopt;
    std::vector<TimedError> lower_ends;
    for (const TimedError& point : curve) {
        if (!point.interval) return std::nullopt;
        lower_ends.push_back({point.seconds, std::max(point.interval->least, 0.0)});
    }
    const auto reached = crossing(lower_ends, error);
    if (!reached) return std::nullopt;
    const bool unknown = lower_ends[reached->point].error == 0 && reached->point > 0;
    const double earliest = unknown ? lower_ends[reached->point - 1].seconds : reached->seconds;
    // A rise at the last point draws up the fit of lower ends alone.
    return std::min(earliest, time_to_error(curve, error).value_or(earliest));
}

std::optional<TimedError> error_at_time(std::span<const TimedError> curve, double seconds) {
    if (curve.empty() || !(seconds >= curve.front().seconds) || seconds > curve.back().seconds) return std::nullopt;
    const auto after = std::lower_bound(curve.begin(), curve.end(), seconds,
                                        [](const TimedError& point, double time) { return point.seconds < time; });
    if (after->seconds == seconds) return *after;
    const auto before = after - 1;
    const double share = log_share(before->seconds, after->seconds, seconds);
    TimedError point{seconds, positive(before->error) && positive(after->error)
                                  ? before->error * std::pow(after->error / before->error, share)
                                  : std::lerp(before->error, after->error, share)};
    if (before->interval && after->interval)
        point.interval = {point.error - std::lerp(before->error - before->interval->least,
                                                  after->error - after->interval->least, share),
                          point.error + std::lerp(before->interval->greatest - before->error,
                                                  after->interval->greatest - after->error, share)};
    return point;
}

std::optional<SeedMean> log_mean(std::span<const double> values) {
    if (values.empty() || !std::all_of(values.begin(), values.end(), positive)) return std::nullopt;
    std::vector<double> logs;
    for (const double value : values) logs.push_back(std::log(value));
    const double mean = mean_of(logs);
    SeedMean result{.mean = std::exp(mean), .low = {}, .high = {}};
    if (values.size() == 1) return result;
    result.low = std::exp(mean - half_width(logs, mean));
    result.high = std::exp(mean + half_width(logs, mean));
    return result;
}

std::optional<SeedMean> arithmetic_mean(std::span<const double> values) {
    const auto finite = [](double value) { return std::isfinite(value); };
    if (values.empty() || !std::all_of(values.begin(), values.end(), finite)) return std::nullopt;
    SeedMean result{.mean = mean_of(values), .low = {}, .high = {}};
    if (values.size() == 1) return result;
    result.low = result.mean - half_width(values, result.mean);
    result.high = result.mean + half_width(values, result.mean);
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

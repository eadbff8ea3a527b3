#pragma once
// Error over time: when to measure, and what is read off a measured curve (conventions.md, "Clock, passes, curves").

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/error/interval.h"

namespace photond {

/// One measurement of a job's film so far. A metric that was not measured here, or has no value, is empty.
struct CurvePoint {
    double seconds = 0;  // on the job's clock
    uint32_t passes = 0;
    std::optional<uint64_t> photons;  // emitted so far; none: the method has none
    std::map<std::string, std::optional<double>> metrics;
    /// Of the metrics that are measured against two references: where their noise lets the value lie (kConfidence).
    std::map<std::string, Interval> intervals = {};
};

/// Points are due after passes 1, 2, 4 ... and at the first pass that ends at or after 0.1 s x 2^k.
class CurveSchedule {
public:
    /// Called after every pass; true when this one is a point. `passes` and `seconds` rise from call to call.
    bool due(uint32_t passes, double seconds);
    /// What due() would say.
    bool is_due(uint32_t passes, double seconds) const { return passes >= next_passes_ || seconds >= next_seconds_; }
    /// As if due() had been called at this point: for a job that goes on from a film.
    void skip_to(uint32_t passes, double seconds);

private:
    uint64_t next_passes_ = 1;
    double next_seconds_ = 0.1;
};

/// Error against time, both positive; seconds rise.
struct TimedError {
    double seconds;
    double error;
};

/// The curve of one metric: points where it has a value above 0, by rising seconds.
std::vector<TimedError> timed_errors(std::span<const CurvePoint> curve, const std::string& metric);

/// The time from which the curve stays at or below `error` (it may cross it several times: noise), by linear
/// interpolation of log error over log time; empty when its last point is above. At or below from the first point on:
/// that point's time, which is an upper bound.
std::optional<double> time_to_error(std::span<const TimedError> curve, double error);

/// The error at a time, interpolated likewise; empty outside the curve's span.
std::optional<double> error_at_time(std::span<const TimedError> curve, double seconds);

/// A mean of positive numbers and its 95 % interval, both of their logarithms (Student's t). With one number there is
/// no interval.
struct LogMean {
    double mean = 0;
    std::optional<double> low, high;
};
std::optional<LogMean> log_mean(std::span<const double> values);

/// Slope of log y over log x by least squares; for theory checks. Empty with fewer than two points.
std::optional<double> log_log_slope(std::span<const double> x, std::span<const double> y);

}  // namespace photond

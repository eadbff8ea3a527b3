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

/// One point of one metric's curve. Seconds are above 0 and rise from point to point. The error may be 0 and, measured
/// against two references, below.
struct TimedError {
    double seconds;
    double error;
    std::optional<Interval> interval = {};  // of an error that is known no better; holds it

    /// What the error is at most: the interval's upper end, or the error itself. Of an error that is not positive the
    /// interval lies too low by luck; then at least half of its width, the upper end of an error of 0: no reference
    /// shows that an error is below what its own noise leaves open (as power-constrained limits do [Cowan et al. 2011],
    /// arXiv:1105.3166). Above 0 unless the error is exactly 0.
    double upper_end() const;
};

/// What one point shows of a metric; empty where that is nothing. A root has no value of what was estimated below 0: it
/// counts as 0, and shows nothing where even its upper end is 0.
std::optional<TimedError> timed_error(const CurvePoint& point, const std::string& metric);

/// The curve of one metric: what its points show, by rising seconds.
std::vector<TimedError> timed_errors(std::span<const CurvePoint> curve, const std::string& metric);

/// The non-increasing sequence whose squared distance from `values` is least, all weighing the same: pooled adjacent
/// violators [Barlow et al. 1972] Statistical Inference under Order Restrictions. It keeps order: where no value is
/// less than another sequence's, none of the fit is.
std::vector<double> non_increasing_fit(std::span<const double> values);

/// When the curve comes to `error`: what a point and the next one are both at most (upper_end()) is fitted by a falling
/// curve in log error, and read where that crosses, linear in log error over log time. So a single dip does not count,
/// nor does the last point, which no other bears out. At the first point: its time, which is an upper bound. Empty
/// where the fit does not come down to `error`, and for an error that is not above 0.
///
/// An error of exactly 0 lies below every other; as it has no logarithm it takes part as the lesser of `error` and the
/// smallest that has one.
///
/// Weights of the fit are equal: what disturbs a curve's order is its own film's path, as large in log error at any
/// point, and the noise of references, which all points share. As the fit keeps order, a time is too early only where
/// upper ends lie below the truth. For an error that falls as 1 / t, measured at doublings, the chance to be
/// too early by a factor f or more is at most 2 (Q(z f) + Q(2 z f) + Q(4 z f) + ...), z = kConfidenceZ and Q the tail
/// of the normal distribution: 10 % by any factor, 0.1 % by 2 (5 and 0.05 % where the points' noise is the same).
std::optional<double> time_to_error(std::span<const TimedError> curve, double error);

/// The smallest error that time_to_error() has a time for, and that of the first point; both above 0. Empty where there
/// is none, or all are 0.
std::optional<Interval> errors_reached(std::span<const TimedError> curve);

/// The earliest that the intervals leave open: likewise of their lower ends, point by point; where one is 0 or less, as
/// of the point before. At most time_to_error(). Empty where lower ends do not come down to `error`, and where a point
/// has no interval.
std::optional<double> earliest_time_to_error(std::span<const TimedError> curve, double error);

/// The point of the curve at a time; empty outside its span. Between points log error is linear in log time, or the
/// error itself where one of both is not positive; what the interval's ends lie off it is linear.
std::optional<TimedError> error_at_time(std::span<const TimedError> curve, double seconds);

/// A mean over seeds and its 95 % interval by Student's t. With one number there is no interval.
struct SeedMean {
    double mean = 0;
    std::optional<double> low, high;
};
/// Of the logarithms; empty unless all values are positive and finite.
std::optional<SeedMean> log_mean(std::span<const double> values);
/// Of the values themselves; empty unless all are finite.
std::optional<SeedMean> arithmetic_mean(std::span<const double> values);

/// Slope of log y over log x by least squares; for theory checks. Empty with fewer than two points.
std::optional<double> log_log_slope(std::span<const double> x, std::span<const double> y);

}  // namespace photond

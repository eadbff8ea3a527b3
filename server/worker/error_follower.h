#pragma once
// Follows the error of a job's film from pass to pass: the points of its curve, and whether its target is met. All of
// it off the job's clock.

#include <functional>
#include <optional>
#include <vector>

#include "protocol/job.h"
#include "protocol/worker_messages.h"
#include "renderer/core/stats.h"
#include "renderer/error/curve.h"
#include "server/worker/film_errors.h"
#include "server/worker/render_meters.h"

namespace photond {

/// Measuring at other points than powers of two, and of metrics that cost much, waits until all measuring so far, the
/// next one, the last one and the statistics at the end together take at most this share of the job's seconds. A
/// shorter job may take as much as one of so many seconds: nobody judges that by its clock.
inline constexpr double kMeasuringShare = 0.02;
inline constexpr double kShortestJudgedSeconds = 2;

/// What a job measures.
struct MeasuringPlan {
    std::vector<LayerMetric> cheap;   // at every point of the curve
    std::vector<LayerMetric> costly;  // at points as far as there is time, and in the end
    /// Estimates where there is a reference too: at powers of two, which they compare, as far as there is time, and in
    /// the end.
    std::vector<LayerMetric> estimated;
    std::optional<LayerMetric> target;
    double target_value = 0;
    LayerMetric now;               // the metric of error_now()
    std::set<std::string> layers;  // all that are measured

    /// With a reference: all metrics of the beauty that cost little, those the request names and its target's.
    static MeasuringPlan of(const JobRequest& request, bool has_reference);
};

class ErrorFollower {
public:
    using Clock = std::function<double()>;

    /// Borrows all but the plan. `now`: wall seconds.
    ErrorFollower(MeasuringPlan plan, FilmErrors& errors, Stats& stats, RenderMeters& meters,
                  Clock now = wall_now_seconds);

    /// For a job that goes on from a film: the points it had, and how long measuring took by the stage in `stats`.
    /// True when that film and the point before it meet the target.
    bool go_on_from(const Film& film, std::vector<CurvePoint> curve, double seconds);
    /// Whether after_pass() may measure then: it takes its time, which is not the job's.
    bool may_measure(const Film& film, double seconds) const { return plan_.target || point_is_due(film, seconds); }
    /// After each pass; `seconds` on the job's clock. True when the target is met: the upper end of the error's
    /// interval (the error itself, where it has none) was at most the target when it was looked at now and the time
    /// before.
    bool after_pass(const Film& film, double seconds);
    /// At the job's end: its last point, complete. What is resolved for it serves the statistics too.
    void finish(ResolvedFilm& resolved, double seconds);

    const std::vector<CurvePoint>& curve() const { return curve_; }
    /// Empty before there is a value.
    const std::optional<ErrorNow>& error_now() const { return error_now_; }
    const MeasuringPlan& plan() const { return plan_; }

private:
    void measure_point(ResolvedFilm& resolved, double seconds, bool in_the_end);
    /// What the target's metric comes to now.
    CurvePoint measure_target(ResolvedFilm& resolved);
    void begin_point(const Film& film, double seconds);
    bool point_is_due(const Film& film, double seconds) const;
    bool there_is_time_for(double cost_seconds, double seconds) const;
    double guessed_last_cost() const;
    /// Takes over the error of the moment.
    void note_error(const CurvePoint& point);
    /// Whether that point is at or below the target; empty where it says nothing of it.
    std::optional<bool> below_target(const CurvePoint& point) const;
    /// Whether this look and the one before were at or below the target.
    bool is_met(const CurvePoint& point);
    double guessed_cost(const LayerMetric& metric) const;
    /// Adds the metric's value, and what it took to the costs.
    void measure_timed(ResolvedFilm& resolved, const LayerMetric& metric, CurvePoint& point);

    const MeasuringPlan plan_;
    FilmErrors& errors_;
    Stats& stats_;
    RenderMeters& meters_;
    const Clock now_;
    CurveSchedule schedule_;
    std::vector<CurvePoint> curve_;
    std::optional<ErrorNow> error_now_;
    bool was_below_ = false;                   // the target, at the last look
    double measured_seconds_ = 0;              // all measuring so far
    double cheap_cost_ = 0, target_cost_ = 0;  // of the last time [s]
    std::map<std::string, double> costs_;      // of costly metrics, likewise
    uint32_t checked_passes_ = 0;              // when the target was looked at last
};

}  // namespace photond

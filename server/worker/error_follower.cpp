#include "server/worker/error_follower.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "server/worker/film_history.h"
#include "server/worker/off_the_clock.h"

namespace photond {

namespace {

/// The target is looked at again when the passes have grown by this share.
constexpr double kTargetGrowth = 0.05;

/// About what a costly metric takes, in terms of resolving a layer and sweeping over it once: for its first time.
double relative_cost(Metric metric) {
    switch (metric) {
        case Metric::FlipHdr: return 60;
        case Metric::FlipLdr: return 12;
        default: return 4;
    }
}

/// About what the statistics at the end take (percentiles, the reference's own noise), in the same terms.
constexpr double kStatisticsCost = 6;

LayerMetric metric_named(const std::string& name) {
    const std::optional<LayerMetric> found = layer_metric_named(name);
    if (!found) throw std::logic_error("a request with an unknown metric passed its reader: " + name);
    return *found;
}

}  // namespace

MeasuringPlan MeasuringPlan::of(const JobRequest& request, bool has_reference) {
    MeasuringPlan plan;
    plan.layers.insert("beauty");
    const auto add = [&](const LayerMetric& metric) {
        const MetricInfo& info = metric_info(metric.metric);
        std::vector<LayerMetric>& list = info.costly                              ? plan.costly
                                         : has_reference && !info.needs_reference ? plan.estimated
                                                                                  : plan.cheap;
        if (std::find(list.begin(), list.end(), metric) == list.end()) list.push_back(metric);
        plan.layers.insert(metric.layer);
    };
    for (const MetricInfo& info : kMetrics)
        if (info.values == 1 && !info.costly && (has_reference || !info.needs_reference)) add({"beauty", info.metric});
    for (const std::string& name : request.metrics) add(metric_named(name));
    plan.now.metric = has_reference ? Metric::RelativeMse : Metric::EstimatedRelativeMse;
    if (request.stop.target) {
        plan.target = metric_named(request.stop.target->metric);
        plan.target_value = request.stop.target->value;
        plan.now = *plan.target;
        add(*plan.target);
    }
    return plan;
}

ErrorFollower::ErrorFollower(MeasuringPlan plan, FilmErrors& errors, Stats& stats, RenderMeters& meters, Clock now)
    : plan_(std::move(plan)), errors_(errors), stats_(stats), meters_(meters), now_(std::move(now)) {}

bool ErrorFollower::go_on_from(const Film& film, std::vector<CurvePoint> curve, double seconds) {
    schedule_.skip_to(film.passes(), seconds);
    curve_ = std::move(curve);
    measured_seconds_ = stats_.stage(kErrorMeasuringStage).wall_seconds;
    if (!curve_.empty()) note_error(curve_.back());
    if (!plan_.target) return false;
    const auto before = std::find_if(curve_.rbegin(), curve_.rend(),
                                     [&](const CurvePoint& point) { return point.passes < film.passes(); });
    was_below_ = before != curve_.rend() && below_target(*before).value_or(false);
    ResolvedFilm resolved(film);
    return is_met(measure_target(resolved));
}

bool ErrorFollower::there_is_time_for(double cost_seconds, double seconds) const {
    return measured_seconds_ + cost_seconds + guessed_last_cost() <=
           kMeasuringShare * std::max(seconds, kShortestJudgedSeconds);
}

/// Of finish(), which measures everything, and of the statistics after it.
double ErrorFollower::guessed_last_cost() const {
    double cost = (1 + kStatisticsCost) * cheap_cost_;
    for (const LayerMetric& metric : plan_.costly) cost += guessed_cost(metric);
    for (const LayerMetric& metric : plan_.estimated) cost += guessed_cost(metric);
    return cost;
}

bool ErrorFollower::point_is_due(const Film& film, double seconds) const {
    if (!schedule_.is_due(film.passes(), seconds)) return false;
    return std::has_single_bit(film.passes()) || there_is_time_for(cheap_cost_, seconds);
}

double ErrorFollower::guessed_cost(const LayerMetric& metric) const {
    const auto known = costs_.find(metric.name());
    return known != costs_.end() ? known->second : relative_cost(metric.metric) * cheap_cost_;
}

void ErrorFollower::note_error(const CurvePoint& point) {
    const std::string name = plan_.now.name();
    const auto value = point.metrics.find(name);
    const auto interval = point.intervals.find(name);
    const bool has_interval = interval != point.intervals.end();
    if (value == point.metrics.end() || (!value->second && !has_interval)) return;
    error_now_ = ErrorNow{name, value->second, std::nullopt};
    if (has_interval) error_now_->interval = {interval->second.least, interval->second.greatest};
}

std::optional<bool> ErrorFollower::below_target(const CurvePoint& point) const {
    const std::optional<TimedError> error = timed_error(point, plan_.target->name());
    if (!error) return std::nullopt;
    return error->upper_end() <= plan_.target_value;
}

bool ErrorFollower::is_met(const CurvePoint& point) {
    note_error(point);
    if (!plan_.target) return false;
    const std::optional<bool> below = below_target(point);
    if (!below) return false;
    return std::exchange(was_below_, *below) && *below;
}

bool ErrorFollower::after_pass(const Film& film, double seconds) {
    if (point_is_due(film, seconds)) {
        schedule_.skip_to(film.passes(), seconds);
        ResolvedFilm resolved(film);
        measure_point(resolved, seconds, false);
        return is_met(curve_.back());
    }
    if (!plan_.target || film.passes() < std::ceil((1 + kTargetGrowth) * checked_passes_) ||
        !there_is_time_for(target_cost_, seconds))
        return false;
    ResolvedFilm resolved(film);
    const CurvePoint look = measure_target(resolved);
    if (!was_below_ && below_target(look).value_or(false)) {
        // With the last point, which every job has, this one shows on the curve too that the target was met twice.
        begin_point(film, seconds);
        curve_.back().metrics = look.metrics, curve_.back().intervals = look.intervals;
        measure_point(resolved, seconds, false);
    }
    return is_met(look);
}

CurvePoint ErrorFollower::measure_target(ResolvedFilm& resolved) {
    const OffTheClock measuring(stats_, kErrorMeasuringStage, meters_);
    const double start = now_();
    CurvePoint point;
    errors_.measure(resolved, std::span(&*plan_.target, 1), point);
    target_cost_ = now_() - start;
    measured_seconds_ += target_cost_;
    checked_passes_ = resolved.film().passes();
    return point;
}

void ErrorFollower::begin_point(const Film& film, double seconds) {
    const uint64_t photons = stats_.counts.photons_emitted;
    curve_.push_back({seconds, film.passes(), photons ? std::optional(photons) : std::nullopt, {}, {}});
}

void ErrorFollower::measure_point(ResolvedFilm& resolved, double seconds, bool in_the_end) {
    const OffTheClock measuring(stats_, kErrorMeasuringStage, meters_);
    const double start = now_();
    const Film& film = resolved.film();
    // One of these passes has some of its metrics already.
    if (curve_.empty() || curve_.back().passes != film.passes()) begin_point(film, seconds);
    CurvePoint& point = curve_.back();
    errors_.measure(resolved, plan_.cheap, point);
    cheap_cost_ = now_() - start;
    measured_seconds_ += cheap_cost_;
    const auto measure_if = [&](bool due, const LayerMetric& metric) {
        if (!point.metrics[metric.name()] && (due || there_is_time_for(guessed_cost(metric), seconds)))
            measure_timed(resolved, metric, point);
    };
    if (in_the_end || std::has_single_bit(film.passes()))
        for (const LayerMetric& metric : plan_.estimated) measure_if(in_the_end, metric);
    for (const LayerMetric& metric : plan_.costly) measure_if(in_the_end, metric);
    if (!plan_.target || !below_target(point)) return;
    checked_passes_ = film.passes();
    const auto cost = costs_.find(plan_.target->name());
    target_cost_ = cost != costs_.end() ? cost->second : cheap_cost_;
}

void ErrorFollower::measure_timed(ResolvedFilm& resolved, const LayerMetric& metric, CurvePoint& point) {
    const double start = now_();
    errors_.measure(resolved, std::span(&metric, 1), point);
    const double cost = now_() - start;
    costs_[metric.name()] = cost;
    measured_seconds_ += cost;
}

void ErrorFollower::finish(ResolvedFilm& resolved, double seconds) {
    const uint32_t passes = resolved.film().passes();
    if (passes == 0) return;
    const bool has_point = !curve_.empty() && curve_.back().passes == passes;
    const auto measured = [&](const LayerMetric& metric) {
        const auto value = curve_.back().metrics.find(metric.name());
        return value != curve_.back().metrics.end() && value->second;
    };
    const auto complete = [&] {
        return std::all_of(plan_.costly.begin(), plan_.costly.end(), measured) &&
               std::all_of(plan_.estimated.begin(), plan_.estimated.end(), measured);
    };
    if (!has_point || !complete()) measure_point(resolved, seconds, true);
    note_error(curve_.back());
}

}  // namespace photond

#include "server/comparisons/table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "renderer/error/cross_meter.h"
#include "renderer/error/seed_errors.h"
#include "server/comparisons/left_out_marks.h"
#include "server/comparisons/levels.h"
#include "server/comparisons/pareto.h"
#include "server/left_out_json.h"

namespace photond {
namespace {

using nlohmann::json;
using Curves = std::vector<std::vector<TimedError>>;  // of one metric, one a job

constexpr size_t kMostLevels = 12;            // of errors and of times in a table
constexpr double kShortestTime_s = 0.1;       // of the tables, unless everything was over before
constexpr double kShortest_s = 1e-6;          // of a clock less what it may be too long
constexpr double kNearReference = 3;          // what is measured over the reference's own noise
constexpr double kSpanOfShortTables = 1.0e2;  // longest over shortest time, where all was over within ten seconds

/// A row's jobs: a part of the whole list.
struct RowRange {
    size_t begin, end;
};

std::vector<RowRange> row_ranges(std::span<const MeasuredJob> jobs) {
    std::vector<RowRange> ranges;
    for (size_t i = 0; i < jobs.size(); ++i) {
        const bool same = i > 0 && jobs[i].label == jobs[i - 1].label && jobs[i].parameters == jobs[i - 1].parameters;
        if (same)
            ++ranges.back().end;
        else
            ranges.push_back({i, i + 1});
    }
    return ranges;
}

void widen(std::optional<Spread>& spread, double value) {
    if (!spread)
        spread = Spread{value, value};
    else
        spread = Spread{std::min(spread->min, value), std::max(spread->max, value)};
}

/// The worst of what a row's seeds that have begun came to: every level from here on was reached by them.
std::optional<double> reached_by_all(const Curves& curves, const RowRange& row) {
    std::optional<double> worst;
    for (size_t i = row.begin; i < row.end; ++i)
        if (const auto reached = errors_reached(curves[i])) worst = std::max(worst.value_or(0), reached->least);
    return worst;
}

/// Errors at which a time can be told, the largest first.
std::vector<double> error_levels(const Curves& curves, std::span<const RowRange> rows, std::optional<double> wish) {
    double best = std::numeric_limits<double>::infinity(), worst_first = 0;
    for (const RowRange& row : rows)
        if (const auto reached = reached_by_all(curves, row)) best = std::min(best, *reached);
    for (const auto& curve : curves)
        if (const auto reached = errors_reached(curve)) worst_first = std::max(worst_first, reached->greatest);
    std::vector<double> levels;
    if (worst_first > 0) {
        // A level that every curve begins below tells nothing.
        levels = round_levels(best, worst_first);
        if (levels.empty()) levels.push_back(round_level_above(best));
        if (levels.size() > kMostLevels) levels.resize(kMostLevels);  // the easy ones go
    }
    if (wish && *wish > 0 && std::find(levels.begin(), levels.end(), *wish) == levels.end()) levels.push_back(*wish);
    std::sort(levels.begin(), levels.end(), std::greater<>());
    return levels;
}

/// Times at which some curve has an error, rising.
std::vector<double> time_levels(const Curves& curves, std::optional<double> wish) {
    double first = std::numeric_limits<double>::infinity(), longest = 0;
    for (const auto& curve : curves)
        if (!curve.empty()) {
            first = std::min(first, curve.front().seconds);
            longest = std::max(longest, curve.back().seconds);
        }
    if (!(longest > 0)) return {};
    const double shortest = std::max(first, std::min(kShortestTime_s, longest / kSpanOfShortTables));
    std::vector<double> levels = round_levels(shortest, longest);
    if (levels.size() > kMostLevels) levels.erase(levels.begin(), levels.end() - kMostLevels);
    if (wish && *wish >= first && *wish <= longest && std::find(levels.begin(), levels.end(), *wish) == levels.end())
        levels.push_back(*wish);
    std::sort(levels.begin(), levels.end());
    return levels;
}

/// log_mean where there is a value for each of `wanted`.
std::optional<SeedMean> mean_of_all(const std::vector<double>& values, size_t wanted) {
    return values.size() == wanted ? log_mean(values) : std::nullopt;
}

std::optional<double> figure_of_all(const std::vector<double>& values, size_t wanted) {
    const auto mean = mean_of_all(values, wanted);
    return mean ? std::optional(mean->mean) : std::nullopt;
}

TimeToError time_of_row(const Curves& curves, std::span<const MeasuredJob> jobs, const RowRange& row, double error,
                        bool ended_by_time) {
    std::vector<double> seconds, earliest, undisturbed;
    TimeToError found{.error = error, .seconds = {}};
    bool disturbed = false, intervals = false;
    for (size_t i = row.begin; i < row.end; ++i) {
        const auto time = time_to_error(curves[i], error), first = earliest_time_to_error(curves[i], error);
        if (time) {
            seconds.push_back(*time);
            found.at_most = found.at_most || *time == curves[i].front().seconds;
        }
        if (first) earliest.push_back(*first);
        intervals = intervals || first;
        disturbed = disturbed || jobs[i].loss;
        // Whenever in its course the processors were missing.
        const double too_long = jobs[i].loss ? jobs[i].loss->clock_seconds : 0;
        if (time || ended_by_time)
            undisturbed.push_back(std::max(time.value_or(jobs[i].seconds) - too_long, kShortest_s));
    }
    const size_t seeds = row.end - row.begin;
    found.seconds = mean_of_all(seconds, seeds);
    found.reached = seconds.size();
    found.earliest = figure_of_all(earliest, seeds);
    if (intervals) found.latest = figure_of_all(seconds, seeds);
    if (disturbed) found.undisturbed = mean_of_all(undisturbed, seeds);
    return found;
}

/// What the row's curves are at a time, of those that span it.
std::vector<TimedError> errors_at(const Curves& curves, const RowRange& row, double time) {
    std::vector<TimedError> errors;
    for (size_t i = row.begin; i < row.end; ++i)
        if (const auto error = error_at_time(curves[i], time)) errors.push_back(*error);
    return errors;
}

std::vector<ErrorAtTime> errors_at_times(const Curves& curves, const RowRange& row, std::span<const double> times) {
    std::vector<ErrorAtTime> found;
    for (const double time : times) {
        const std::vector<TimedError> errors = errors_at(curves, row, time);
        found.push_back(
            {time, errors.size() == row.end - row.begin ? mean_error(errors) : std::nullopt, errors.size()});
    }
    return found;
}

/// Of at least one.
MeanPoint mean_point(double seconds, std::span<const TimedError> errors) {
    std::optional<Spread> seeds;
    for (const TimedError& error : errors) widen(seeds, error.error);
    return {seconds, *mean_error(errors), *seeds};
}

/// The mean of the seeds' last points.
MeanPoint mean_end(const Curves& curves, const RowRange& row) {
    std::vector<double> seconds;
    std::vector<TimedError> errors;
    for (size_t i = row.begin; i < row.end; ++i)
        if (!curves[i].empty()) {
            seconds.push_back(curves[i].back().seconds);
            errors.push_back(curves[i].back());
        }
    return mean_point(log_mean(seconds)->mean, errors);
}

std::vector<MeanPoint> mean_curve(const Curves& curves, const RowRange& row) {
    double from = 0, to = std::numeric_limits<double>::infinity();
    const std::vector<TimedError>* first = nullptr;
    for (size_t i = row.begin; i < row.end; ++i) {
        if (curves[i].empty()) continue;
        if (first == nullptr) first = &curves[i];
        from = std::max(from, curves[i].front().seconds);
        to = std::min(to, curves[i].back().seconds);
    }
    if (first == nullptr) return {};
    if (to < from) return {mean_end(curves, row)};  // measured so rarely that there is no time they share
    std::vector<double> times{from};
    for (const TimedError& point : *first)
        if (point.seconds > from && point.seconds < to) times.push_back(point.seconds);
    if (to > from) times.push_back(to);
    std::vector<MeanPoint> points;
    points.reserve(times.size());
    for (const double time : times) points.push_back(mean_point(time, errors_at(curves, row, time)));
    return points;
}

/// A metric of a finished job: what its statistics say, else the last point of its curve. Like timed_errors() it takes
/// the root of what was estimated below 0 for 0.
std::optional<TimedError> final_error(const MeasuredJob& job, const std::string& metric) {
    const auto value = job.error.find(metric);
    const auto interval = job.error_interval.find(metric);
    if (value == job.error.end() && interval == job.error_interval.end()) {
        if (job.curve.empty()) return std::nullopt;
        const std::vector<TimedError> last = timed_errors(std::span(job.curve).last(1), metric);
        return last.empty() ? std::nullopt : std::optional(last.front());
    }
    TimedError error{job.seconds, value != job.error.end() ? value->second : 0};
    if (interval != job.error_interval.end()) error.interval = interval->second;
    return error;
}

bool is_near_reference(const MeanError& mean, std::optional<double> noise) {
    if (mean.interval) return 0.5 * (mean.interval->greatest - mean.interval->least) > mean.error.mean / kNearReference;
    return noise && mean.error.mean <= kNearReference * *noise;
}

FinalError final_error(std::span<const MeasuredJob> jobs, const std::string& metric, std::optional<double> reference) {
    std::vector<TimedError> errors;
    for (const MeasuredJob& job : jobs)
        if (job.succeeded())
            if (const auto error = final_error(job, metric)) errors.push_back(*error);
    FinalError result{mean_error(errors), reference, false};
    result.near_reference = result.mean && is_near_reference(*result.mean, reference);
    return result;
}

/// "indirect:mse" for "indirect:relative_mse".
std::string beside(const std::string& metric, const char* measure) {
    const size_t colon = metric.find(':');
    return (colon == std::string::npos ? "" : metric.substr(0, colon + 1)) + measure;
}

/// The mean square beside a metric; of results of before, which may lack it, by its root.
std::optional<double> final_mse(const MeasuredJob& job, const std::string& metric) {
    if (const auto mse = final_error(job, beside(metric, "mse"))) return mse->error;
    const auto rmse = final_error(job, beside(metric, "rmse"));
    return rmse ? std::optional(rmse->error * rmse->error) : std::nullopt;
}

std::optional<double> efficiency(std::span<const MeasuredJob> jobs, const std::string& metric) {
    double sum = 0;
    size_t count = 0;
    for (const MeasuredJob& job : jobs) {
        const auto mse = job.succeeded() ? final_mse(job, metric) : std::nullopt;
        if (!mse || !(job.seconds > 0)) continue;
        sum += *mse * job.seconds;
        ++count;
    }
    return sum > 0 ? std::optional(static_cast<double>(count) / sum) : std::nullopt;
}

std::optional<double> reference_noise(std::span<const MeasuredJob> jobs, const std::string& metric) {
    for (const MeasuredJob& job : jobs)  // one reference, one noise
        if (const auto found = job.reference_error.find(metric); found != job.reference_error.end())
            return found->second;
    return std::nullopt;
}

TableRow make_row(std::span<const MeasuredJob> jobs) {
    TableRow row;
    row.label = jobs.front().label;
    row.parameters = jobs.front().parameters;
    row.seeds = jobs.size();
    for (const MeasuredJob& job : jobs) {
        row.jobs.push_back(job.id);
        if (!row.left_out) row.left_out = job.left_out;
        if (!job.succeeded()) continue;
        ++row.succeeded;
        row.disturbed += job.loss.has_value();
        widen(row.passes, static_cast<double>(job.passes));
        widen(row.seconds, job.seconds);
        if (job.photons) widen(row.photons, static_cast<double>(*job.photons));
        if (job.peak_bytes) row.peak_bytes = std::max(row.peak_bytes.value_or(0), *job.peak_bytes);
    }
    return row;
}

void add_metric(ComparisonTable& table, std::span<const MeasuredJob> jobs, std::span<const RowRange> ranges,
                const std::string& metric, const TableWishes& wishes) {
    Curves curves;
    for (const MeasuredJob& job : jobs) curves.push_back(timed_errors(job.curve, metric));
    const auto wish = wishes.error.find(metric);
    const std::vector<double> levels =
        error_levels(curves, ranges, wish != wishes.error.end() ? std::optional(wish->second) : std::nullopt);
    const std::vector<double> times = time_levels(curves, wishes.seconds);
    const std::optional<double> reference = reference_noise(jobs, metric);
    for (size_t r = 0; r < ranges.size(); ++r) {
        TableRow& row = table.rows[r];
        const RowRange& range = ranges[r];
        std::vector<TimeToError>& times_to_errors = row.time_to_error[metric];
        for (const double error : levels)
            times_to_errors.push_back(time_of_row(curves, jobs, range, error, wishes.seconds.has_value()));
        row.error_at_time[metric] = errors_at_times(curves, range, times);
        row.mean_curve[metric] = mean_curve(curves, range);
        row.error[metric] = final_error(jobs.subspan(range.begin, range.end - range.begin), metric, reference);
    }
}

void mark_pareto(ComparisonTable& table) {
    Curves curves;
    for (const TableRow& row : table.rows) {
        curves.emplace_back();
        for (const MeanPoint& point : row.mean_curve.at(table.metrics.front()))
            if (const double error = point.mean.upper_end(); error > 0) curves.back().push_back({point.seconds, error});
    }
    const std::vector<bool> front = pareto_front(curves);
    for (size_t r = 0; r < table.rows.size(); ++r) table.rows[r].pareto = front[r];
}

json or_null(const auto& value) { return value ? json(*value) : json(); }

json spread_json(const std::optional<Spread>& spread) {
    return spread ? json{{"min", spread->min}, {"max", spread->max}} : json();
}

json counts_json(const std::optional<Spread>& spread) {
    if (!spread) return nullptr;
    return {{"min", static_cast<uint64_t>(spread->min)}, {"max", static_cast<uint64_t>(spread->max)}};
}

/// The mean as `name`, and its interval over the seeds.
void put_mean(json& object, const char* name, const std::optional<SeedMean>& mean) {
    object[name] = mean ? json(mean->mean) : json();
    object["low"] = mean ? or_null(mean->low) : json();
    object["high"] = mean ? or_null(mean->high) : json();
}

/// Likewise, and what the references' noise leaves open.
void put_mean(json& object, const char* name, const std::optional<MeanError>& mean) {
    put_mean(object, name, mean ? std::optional(mean->error) : std::nullopt);
    object["interval"] = nullptr;
    if (mean && mean->interval) object["interval"] = {mean->interval->least, mean->interval->greatest};
}

json bias_json(const TableRow& row) {
    if (!row.bias) return nullptr;
    json metrics = json::object();
    for (const auto& [metric, parts] : *row.bias)
        metrics[metric] = {{"squared_bias", parts.squared_bias},
                           {"low", parts.low},
                           {"high", parts.high},
                           {"variance", parts.variance},
                           {"variance_low", or_null(parts.variance_low)},
                           {"variance_high", or_null(parts.variance_high)},
                           {"floor", parts.floor},
                           {"text", parts.text}};
    return metrics;
}

json row_json(const TableRow& row, const std::string& mark) {
    json time_to_error = json::object(), error_at_time = json::object(), errors = json::object();
    for (const auto& [metric, levels] : row.time_to_error) {
        json& list = time_to_error[metric] = json::array();
        for (const TimeToError& level : levels) {
            json item{{"error", level.error},
                      {"reached", level.reached},
                      {"at_most", level.at_most},
                      {"earliest", or_null(level.earliest)},
                      {"latest", or_null(level.latest)}};
            put_mean(item, "seconds", level.seconds);
            list.push_back(std::move(item));
        }
    }
    for (const auto& [metric, times] : row.error_at_time) {
        json& list = error_at_time[metric] = json::array();
        for (const ErrorAtTime& time : times) {
            json item{{"seconds", time.seconds}, {"reached", time.reached}};
            put_mean(item, "error", time.mean);
            list.push_back(std::move(item));
        }
    }
    for (const auto& [metric, error] : row.error) {
        json item{{"reference", or_null(error.reference)}, {"near_reference", error.near_reference}};
        put_mean(item, "value", error.mean);
        errors[metric] = std::move(item);
    }
    return {{"label", row.label},
            {"parameters", row.parameters},
            {"jobs", row.jobs},
            {"seeds", row.seeds},
            {"succeeded", row.succeeded},
            {"disturbed", row.disturbed},
            {"passes", counts_json(row.passes)},
            {"photons", counts_json(row.photons)},
            {"seconds", spread_json(row.seconds)},
            {"error", std::move(errors)},
            {"time_to_error", std::move(time_to_error)},
            {"error_at_time", std::move(error_at_time)},
            {"peak_bytes", or_null(row.peak_bytes)},
            {"efficiency", or_null(row.efficiency)},
            {"pareto", row.pareto},
            {"bias", bias_json(row)},
            {"left_out", row.left_out ? to_json(*row.left_out) : json()},
            {"mark", mark.empty() ? json() : json(mark)}};
}

}  // namespace

std::optional<double> MeanError::drawn() const {
    if (!is_bound()) return error.mean;
    const double bound = upper_end();
    return bound > 0 ? std::optional(bound) : std::nullopt;
}

std::optional<LayerMetric> mean_square_named(const std::string& metric) {
    const auto named = layer_metric_named(metric);
    if (!named || !is_quadratic(named->metric)) return std::nullopt;
    return LayerMetric{named->layer, mean_square_of(named->metric)};
}

const BiasApart* bias_of(const TableRow& row, const std::string& metric) {
    const auto mean_square = mean_square_named(metric);
    if (!row.bias || !mean_square) return nullptr;
    const auto parts = row.bias->find(mean_square->name());
    return parts != row.bias->end() ? &parts->second : nullptr;
}

std::optional<double> floor_of(const TableRow& row, const std::string& metric) {
    const BiasApart* parts = bias_of(row, metric);
    const auto least = parts ? parts->least() : std::nullopt;
    if (!least) return std::nullopt;
    return mean_square_named(metric)->name() == metric ? *least : std::sqrt(*least);
}

std::optional<MeanError> mean_error(std::span<const TimedError> errors) {
    std::vector<double> values;
    bool as_they_are = false, intervals = true;
    for (const TimedError& error : errors) {
        values.push_back(error.error);
        as_they_are = as_they_are || error.interval || !(error.error > 0);
        intervals = intervals && error.interval;
    }
    const auto mean = as_they_are ? arithmetic_mean(values) : log_mean(values);
    if (!mean) return std::nullopt;
    MeanError result{*mean};
    if (!intervals) return result;
    Interval& ends = result.interval.emplace();
    for (const TimedError& error : errors) {
        ends.least += error.interval->least / static_cast<double>(errors.size());
        ends.greatest += error.interval->greatest / static_cast<double>(errors.size());
    }
    return result;
}

ComparisonTable make_table(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics,
                           const TableWishes& wishes) {
    ComparisonTable table;
    table.metrics = metrics;
    const std::vector<RowRange> ranges = row_ranges(jobs);
    for (const RowRange& range : ranges) {
        const auto of_row = jobs.subspan(range.begin, range.end - range.begin);
        table.rows.push_back(make_row(of_row));
        if (!metrics.empty()) table.rows.back().efficiency = efficiency(of_row, metrics.front());
    }
    for (const std::string& metric : metrics) add_metric(table, jobs, ranges, metric, wishes);
    if (!metrics.empty()) mark_pareto(table);
    return table;
}

json to_json(const ComparisonTable& table) {
    json rows = json::array();
    for (const TableRow& row : table.rows) rows.push_back(row_json(row, mark_text(table, row)));
    return rows;
}

json mean_curves_json(const TableRow& row) {
    json curves = json::object();
    for (const auto& [metric, points] : row.mean_curve) {
        json& list = curves[metric] = json::array();
        for (const MeanPoint& point : points) {
            json item{{"seconds", point.seconds}, {"min", point.seeds.min}, {"max", point.seeds.max}};
            put_mean(item, "error", point.mean);
            list.push_back(std::move(item));
        }
    }
    return curves;
}

std::string row_name(const std::string& label, const json& parameters) {
    std::string name = label;
    for (const auto& [parameter, value] : parameters.items())
        name += ", " + parameter + " " + (value.is_string() ? value.get<std::string>() : value.dump());
    return name;
}

}  // namespace photond

#include "server/comparisons/table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "server/comparisons/levels.h"
#include "server/comparisons/pareto.h"

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

/// The worst last error of a row's seeds that have begun: every level from here on was reached by them.
std::optional<double> reached_by_all(const Curves& curves, const RowRange& row) {
    std::optional<double> worst;
    for (size_t i = row.begin; i < row.end; ++i)
        if (!curves[i].empty()) worst = std::max(worst.value_or(0), curves[i].back().error);
    return worst;
}

/// Errors at which a time can be told, the largest first.
std::vector<double> error_levels(const Curves& curves, std::span<const RowRange> rows, std::optional<double> wish) {
    double best = std::numeric_limits<double>::infinity(), worst_first = 0;
    for (const RowRange& row : rows)
        if (const auto reached = reached_by_all(curves, row)) best = std::min(best, *reached);
    for (const auto& curve : curves)
        if (!curve.empty()) worst_first = std::max(worst_first, curve.front().error);
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
std::optional<LogMean> mean_of_all(const std::vector<double>& values, size_t wanted) {
    return values.size() == wanted ? log_mean(values) : std::nullopt;
}

std::vector<TimeToError> times_to_errors(const Curves& curves, std::span<const MeasuredJob> jobs, const RowRange& row,
                                         std::span<const double> levels, bool ended_by_time) {
    std::vector<TimeToError> found;
    const bool disturbed = std::any_of(jobs.begin() + static_cast<std::ptrdiff_t>(row.begin),
                                       jobs.begin() + static_cast<std::ptrdiff_t>(row.end),
                                       [](const MeasuredJob& job) { return job.loss; });
    for (const double error : levels) {
        std::vector<double> seconds, earliest;
        bool at_most = false;
        for (size_t i = row.begin; i < row.end; ++i) {
            const auto time = time_to_error(curves[i], error);
            if (time) {
                seconds.push_back(*time);
                at_most = at_most || *time == curves[i].front().seconds;
            }
            // Whenever in its course the processors were missing.
            const double too_long = jobs[i].loss ? jobs[i].loss->clock_seconds : 0;
            if (time || ended_by_time)
                earliest.push_back(std::max(time.value_or(jobs[i].seconds) - too_long, kShortest_s));
        }
        const size_t seeds = row.end - row.begin;
        found.push_back({error, mean_of_all(seconds, seeds), seconds.size(), at_most,
                         disturbed ? mean_of_all(earliest, seeds) : std::nullopt});
    }
    return found;
}

std::vector<ErrorAtTime> errors_at_times(const Curves& curves, const RowRange& row, std::span<const double> times) {
    std::vector<ErrorAtTime> found;
    for (const double time : times) {
        std::vector<double> errors;
        for (size_t i = row.begin; i < row.end; ++i)
            if (const auto error = error_at_time(curves[i], time)) errors.push_back(*error);
        found.push_back({time, mean_of_all(errors, row.end - row.begin), errors.size()});
    }
    return found;
}

/// Of at least one.
Spread spread_of(const std::vector<double>& values) {
    const auto [min, max] = std::minmax_element(values.begin(), values.end());
    return {*min, *max};
}

/// The mean of the seeds' last points.
MeanPoint mean_end(const Curves& curves, const RowRange& row) {
    std::vector<double> seconds, errors;
    for (size_t i = row.begin; i < row.end; ++i)
        if (!curves[i].empty()) {
            seconds.push_back(curves[i].back().seconds);
            errors.push_back(curves[i].back().error);
        }
    return {log_mean(seconds)->mean, *log_mean(errors), spread_of(errors)};
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
    for (const double time : times) {
        std::vector<double> errors;
        for (size_t i = row.begin; i < row.end; ++i)
            if (const auto error = error_at_time(curves[i], time)) errors.push_back(*error);
        if (const auto mean = log_mean(errors)) points.push_back({time, *mean, spread_of(errors)});
    }
    return points;
}

void widen(std::optional<Spread>& spread, double value) {
    if (!spread)
        spread = Spread{value, value};
    else
        spread = Spread{std::min(spread->min, value), std::max(spread->max, value)};
}

/// A metric of a finished job: what its statistics say, else the last point of its curve.
std::optional<double> final_error(const MeasuredJob& job, const std::string& metric) {
    if (const auto found = job.error.find(metric); found != job.error.end()) return found->second;
    if (job.curve.empty()) return std::nullopt;
    const auto found = job.curve.back().metrics.find(metric);
    return found != job.curve.back().metrics.end() ? found->second : std::nullopt;
}

FinalError final_error(std::span<const MeasuredJob> jobs, const std::string& metric, std::optional<double> reference) {
    std::vector<double> values;
    for (const MeasuredJob& job : jobs)
        if (job.succeeded())
            if (const auto error = final_error(job, metric)) values.push_back(*error);
    FinalError result{log_mean(values), reference, false};
    result.near_reference = result.error && reference && result.error->mean <= kNearReference * *reference;
    return result;
}

/// "indirect:rmse" for "indirect:relative_mse".
std::string rmse_beside(const std::string& metric) {
    const size_t colon = metric.find(':');
    return (colon == std::string::npos ? "" : metric.substr(0, colon + 1)) + "rmse";
}

std::optional<double> efficiency(std::span<const MeasuredJob> jobs, const std::string& rmse) {
    double sum = 0;
    size_t count = 0;
    for (const MeasuredJob& job : jobs) {
        const auto error = job.succeeded() ? final_error(job, rmse) : std::nullopt;
        if (!error || !(*error > 0) || !(job.seconds > 0)) continue;
        sum += 1 / (*error * *error * job.seconds);
        ++count;
    }
    if (count == 0) return std::nullopt;
    return sum / static_cast<double>(count);
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
        row.time_to_error[metric] = times_to_errors(curves, jobs, range, levels, wishes.seconds.has_value());
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
            curves.back().push_back({point.seconds, point.error.mean});
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

/// The mean as `name`, and its interval.
void put_mean(json& object, const char* name, const std::optional<LogMean>& mean) {
    object[name] = mean ? json(mean->mean) : json();
    object["low"] = mean ? or_null(mean->low) : json();
    object["high"] = mean ? or_null(mean->high) : json();
}

json row_json(const TableRow& row) {
    json time_to_error = json::object(), error_at_time = json::object(), errors = json::object();
    for (const auto& [metric, levels] : row.time_to_error) {
        json& list = time_to_error[metric] = json::array();
        for (const TimeToError& level : levels) {
            json item{{"error", level.error}, {"reached", level.reached}, {"at_most", level.at_most}};
            put_mean(item, "seconds", level.seconds);
            list.push_back(std::move(item));
        }
    }
    for (const auto& [metric, times] : row.error_at_time) {
        json& list = error_at_time[metric] = json::array();
        for (const ErrorAtTime& time : times) {
            json item{{"seconds", time.seconds}, {"reached", time.reached}};
            put_mean(item, "error", time.error);
            list.push_back(std::move(item));
        }
    }
    for (const auto& [metric, error] : row.error) {
        json item{{"reference", or_null(error.reference)}, {"near_reference", error.near_reference}};
        put_mean(item, "value", error.error);
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
            {"pareto", row.pareto}};
}

}  // namespace

ComparisonTable make_table(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics,
                           const TableWishes& wishes) {
    ComparisonTable table;
    table.metrics = metrics;
    const std::vector<RowRange> ranges = row_ranges(jobs);
    for (const RowRange& range : ranges) {
        const auto of_row = jobs.subspan(range.begin, range.end - range.begin);
        table.rows.push_back(make_row(of_row));
        if (!metrics.empty()) table.rows.back().efficiency = efficiency(of_row, rmse_beside(metrics.front()));
    }
    for (const std::string& metric : metrics) add_metric(table, jobs, ranges, metric, wishes);
    if (!metrics.empty()) mark_pareto(table);
    return table;
}

json to_json(const ComparisonTable& table) {
    json rows = json::array();
    for (const TableRow& row : table.rows) rows.push_back(row_json(row));
    return rows;
}

json mean_curves_json(const TableRow& row) {
    json curves = json::object();
    for (const auto& [metric, points] : row.mean_curve) {
        json& list = curves[metric] = json::array();
        for (const MeanPoint& point : points) {
            json item{{"seconds", point.seconds}, {"min", point.seeds.min}, {"max", point.seeds.max}};
            put_mean(item, "error", point.error);
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

#include "server/worker/error_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

namespace photond {

using nlohmann::json;

namespace {

/// A figure below so many times the reference's own noise says little of the image.
constexpr double kNoiseMargin = 3;
constexpr std::string_view kMeasuredWithNoise =
    "measured against one image: errors hold its noise as well as the image's own; a reference that is made by its "
    "method is two films, whose noise drops out";

json number_or_null(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }

std::string shown(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

std::string named(const std::string& layer, std::string_view what) {
    return layer == "beauty" ? std::string(what) : layer + ":" + std::string(what);
}

void add_note(json& notes, const std::string& note) {
    if (!note.empty() && std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

/// By channel, of the image's own noise: from the spread between passes of their means, for pixels share photons and
/// lights. Passes of a low-discrepancy sequence make up for each other, so that it is then an upper figure. Null where
/// not all of the passes, or of the image, are known to be in it; a note then says so.
json bias_standard_error(const Film& film, const std::string& layer, uint64_t left_out, json& notes) {
    constexpr std::pair<std::string_view, PassMeans::Of> kOf[] = {
        {"beauty", PassMeans::Of::Beauty}, {"direct", PassMeans::Of::Direct}, {"indirect", PassMeans::Of::Indirect}};
    const auto of = std::find_if(std::begin(kOf), std::end(kOf), [&](const auto& row) { return row.first == layer; });
    if (of == std::end(kOf)) {
        add_note(notes, named(layer, "bias_standard_error") + ": unknown, for passes keep no means of this layer");
        return nullptr;
    }
    if (film.passes() < 2) {
        add_note(notes, "bias_standard_error: unknown after one pass, which has no spread");
        return nullptr;
    }
    if (const uint32_t unknown = film.passes() - film.pass_means().passes()) {
        add_note(notes, "bias_standard_error: unknown, for " + std::to_string(unknown) + " of the " +
                            std::to_string(film.passes()) +
                            " passes are from a film that an older version saved, without their means");
        return nullptr;
    }
    if (left_out > 0) {
        add_note(notes, named(layer, "bias_standard_error") + ": unknown, for passes keep the mean over all values");
        return nullptr;
    }
    std::array<double, 3> standard_error = film.pass_means().variance(of->second).value();
    for (double& value : standard_error) value = std::sqrt(value / film.passes());
    return standard_error;
}

/// Everything that is known of one layer's error.
void add_layer(json& error, json& notes, ResolvedFilm& film, const ErrorMeter& meter, const std::string& layer) {
    const std::vector<float>& pixels = film.pixels(layer);
    const PointwiseErrors& sweep = film.pointwise(layer, meter);
    for (const MetricInfo& info : kMetrics) {
        if (!is_distance(info) || info.costly) continue;
        const std::vector<double> value = sweep.values_of(info.metric);
        error[named(layer, info.name)] = value.empty() ? json(nullptr) : json(value.front());
    }
    error[named(layer, "bias")] = channels_json(sweep.channels(Metric::Bias));
    error[named(layer, "relative_bias")] = channels_json(sweep.channels(Metric::RelativeBias));
    error[named(layer, "least_squares_exposure")] = number_or_null(sweep.least_squares_exposure);
    error[named(layer, "relative_least_squares_exposure")] = number_or_null(sweep.relative_least_squares_exposure);
    error[named(layer, "bias_standard_error")] = bias_standard_error(film.film(), layer, sweep.left_out, notes);
    error[named(layer, "left_out")] = sweep.left_out;
    error[named(layer, "firefly_count")] = meter.firefly_count(pixels);
    error[named(layer, "percentiles")] = nullptr;
    if (const auto percentiles = meter.percentiles(pixels)) {
        json values = json::object();
        for (size_t i = 0; i < kPercentileNames.size(); ++i)
            values[std::string(kPercentileNames[i])] = (*percentiles)[i];
        error[named(layer, "percentiles")] = values;
    }
    if (!sweep[Metric::RelativeMse])
        add_note(notes, sweep.left_out == pixels.size()
                            ? named(layer, "relative_mse") + ": no value of the image and the reference is finite"
                            : named(layer, "relative_mse") + ", percentiles: the reference's mean is 0");
    if (sweep.left_out > 0)
        add_note(notes, std::to_string(sweep.left_out) + " values of " + layer + " are not finite and left out");
}

/// What a layer's quadratic metrics come to against two films, in the place of what they are against their mean.
void add_crossed(ErrorStatistics& statistics, json& denominators, json& notes, ResolvedFilm& film,
                 const CrossMeter& meter, const std::string& layer) {
    const CrossErrors& errors = film.crosswise(layer, meter);
    for (const MetricInfo& info : kMetrics) {
        if (!is_quadratic(info.metric)) continue;
        const std::string name = named(layer, info.name);
        const std::optional<CrossFigure> figure = figure_of(errors, info.metric);
        statistics.error[name] = figure ? number_or_null(figure->value) : json(nullptr);
        if (!figure) continue;
        statistics.error_interval[name] = {figure->interval.least, figure->interval.greatest};
        if (!figure->value) add_note(notes, name + ": " + std::string(kRootBelowZero));
        if (info.metric != Metric::RelativeMse) continue;
        const bool around = figure->denominators == Denominators::Neighbours;
        denominators[name] = around ? "neighbours" : "pixel";
        if (around) add_note(notes, name + ": " + std::string(kDividedByNeighbours));
    }
}

/// The reference as another rendering of its quality would be, against itself. Of two films the first is as far from
/// their mean as another mean of two would be.
std::vector<float> other_reference(const FilmErrors& errors, const std::string& layer) {
    const ErrorMeter& meter = errors.meter(layer);
    if (!errors.crosses()) {
        const std::vector<float>& standard_error = errors.reference_standard_error(layer);
        if (standard_error.empty()) return {};
        return with_own_noise(meter.reference(), standard_error, kReferenceNoiseSeed);
    }
    const std::span<const float> difference = errors.cross_meter(layer).half_difference();
    std::vector<float> other(meter.reference().begin(), meter.reference().end());
    for (size_t i = 0; i < other.size(); ++i) other[i] += difference[i];
    return other;
}

void add_reference_error(json& reference_error, const FilmErrors& errors, const MeasuringPlan& plan,
                         const std::string& layer) {
    const ErrorMeter& meter = errors.meter(layer);
    const auto set = [&](const MetricInfo& info, const std::vector<double>& value) {
        reference_error[named(layer, info.name)] = value.empty() ? json(nullptr) : json(value.front());
    };
    const std::vector<float> noisy = other_reference(errors, layer);
    PointwiseErrors sweep;
    if (!noisy.empty()) sweep = meter.pointwise(noisy);
    for (const MetricInfo& info : kMetrics) {
        if (!is_distance(info)) continue;
        const LayerMetric metric{layer, info.metric};
        const bool asked = std::find(plan.costly.begin(), plan.costly.end(), metric) != plan.costly.end();
        if (info.costly && !asked) continue;
        if (noisy.empty())
            set(info, {});
        else
            set(info, info.costly ? meter.measure(info.metric, noisy) : sweep.values_of(info.metric));
    }
}

/// Of the beauty.
json estimate_json(ResolvedFilm& film, FilmErrors& errors) {
    const std::optional<ErrorEstimate> estimate = errors.estimate(film, "beauty");
    if (!estimate) return nullptr;
    json within = nullptr;
    if (errors.has_reference()) {
        std::vector<float> standard_error = variance_of_mean(film.pass_variance("beauty"), film.film().passes());
        for (float& value : standard_error)
            value = static_cast<float>(estimate->standard_error_scale) * std::sqrt(value);
        within = number_or_null(share_within(film.pixels("beauty"), standard_error, errors.meter("beauty").reference(),
                                             errors.reference_standard_error("beauty"), kConfidenceZ));
    }
    return {{"estimated_relative_mse", estimate->estimated_relative_mse},
            {"standard_error_scale", estimate->standard_error_scale},
            {"confidence", kConfidence},
            {"within_confidence", within}};
}

}  // namespace

json channels_json(const std::array<std::optional<double>, 3>& values) {
    json channels = json::array();
    for (const std::optional<double>& value : values) channels.push_back(number_or_null(value));
    return channels;
}

std::vector<std::string> noise_warnings(const json& error, const json& error_interval, const json& reference_error) {
    std::vector<std::string> warnings;
    for (const auto& [metric, noise] : reference_error.items()) {
        if (error_interval.is_object() && error_interval.contains(metric)) continue;  // that noise is not in it
        const auto value = error.find(metric);
        if (!noise.is_number() || value == error.end() || !value->is_number()) continue;
        if (!(noise > 0) || value->get<double>() > kNoiseMargin * noise.get<double>()) continue;
        warnings.push_back(metric + " is " + shown(*value) + ", less than " + shown(kNoiseMargin) +
                           " times what the reference's own noise explains (" + shown(noise) + ")");
    }
    return warnings;
}

ErrorStatistics error_statistics(ResolvedFilm& film, FilmErrors& errors, const MeasuringPlan& plan,
                                 const CurvePoint& last, const json& asked,
                                 const std::optional<ReferenceSource>& source) {
    ErrorStatistics statistics;
    statistics.estimate = estimate_json(film, errors);
    if (!errors.has_reference()) return statistics;
    statistics.error = statistics.error_interval = statistics.reference_error = json::object();
    json notes = json::array(), denominators = json::object();
    for (const std::string& layer : errors.layers()) {
        add_layer(statistics.error, notes, film, errors.meter(layer), layer);
        if (errors.crosses())
            add_crossed(statistics, denominators, notes, film, errors.cross_meter(layer), layer);
        else
            add_note(notes, std::string(kMeasuredWithNoise));
        add_reference_error(statistics.reference_error, errors, plan, layer);
        if (!errors.crosses() && errors.reference_standard_error(layer).empty())
            add_note(notes, "the reference's own noise is not known for " + layer);
    }
    for (const auto& [metric, value] : last.metrics) statistics.error[metric] = number_or_null(value);
    statistics.warnings = noise_warnings(statistics.error, statistics.error_interval, statistics.reference_error);
    const bool flip = std::any_of(plan.costly.begin(), plan.costly.end(), [](const LayerMetric& metric) {
        return metric.metric == Metric::FlipLdr || metric.metric == Metric::FlipHdr;
    });
    const std::optional<uint32_t> passes = errors.reference_passes();
    statistics.reference = {{"source", asked},
                            {"form", source ? json(source->form()) : json(nullptr)},
                            {"confidence", errors.crosses() ? json(kConfidence) : json(nullptr)},
                            {"denominators", denominators},
                            {"passes", passes ? json(*passes) : json(nullptr)},
                            {"flip_version", flip ? json(kFlipVersion) : json(nullptr)},
                            {"warnings", statistics.warnings},
                            {"notes", notes}};
    return statistics;
}

}  // namespace photond

#include "server/worker/film_errors.h"

#include <algorithm>

#include "protocol/error.h"

namespace photond {

namespace {

bool has_variance(Layer layer) { return layer == Layer::Direct || layer == Layer::Indirect; }

}  // namespace

std::string size_text(Size2 size) { return std::to_string(size.width) + " x " + std::to_string(size.height); }

const std::vector<float>& ResolvedFilm::pixels(const std::string& layer) {
    const auto [found, is_new] = pixels_.try_emplace(layer);
    if (is_new) found->second = layer == "beauty" ? film_.resolve_beauty() : film_.resolve(find_layer(layer)->layer);
    return found->second;
}

const std::vector<float>& ResolvedFilm::pass_variance(const std::string& layer) {
    const auto [found, is_new] = pass_variance_.try_emplace(layer);
    if (is_new && layer == "beauty")
        found->second = film_.pass_variance_beauty();
    else if (is_new && has_variance(find_layer(layer)->layer))
        found->second = film_.pass_variance(find_layer(layer)->layer);
    return found->second;
}

const PointwiseErrors& ResolvedFilm::pointwise(const std::string& layer, const ErrorMeter& meter) {
    const auto [found, is_new] = sweeps_.try_emplace(layer);
    if (is_new) found->second = meter.pointwise(pixels(layer));
    return found->second;
}

const CrossErrors& ResolvedFilm::crosswise(const std::string& layer, const CrossMeter& meter) {
    const auto [found, is_new] = cross_sweeps_.try_emplace(layer);
    if (is_new) found->second = meter.measure(pixels(layer));
    return found->second;
}

std::vector<float> variance_of_mean(std::span<const float> pass_variance, uint32_t passes) {
    std::vector<float> variance(pass_variance.begin(), pass_variance.end());
    for (float& value : variance) value /= static_cast<float>(passes);
    return variance;
}

FilmErrors::FilmErrors(Size2 size, std::optional<LoadedReference> loaded, const std::set<std::string>& layers)
    : size_(size), layers_(layers), has_reference_(loaded.has_value()), crosses_(loaded && loaded->second) {
    for (const std::string& layer : layers_) states_[layer];
    if (!loaded) return;
    if (loaded->first.size != size)
        throw Error(ErrorCode::Conflict, "/reference",
                    "the reference is " + size_text(loaded->first.size) + " pixels, the image " + size_text(size));
    const auto pixels_of = [](const ReferenceImage& image, const std::string& layer) -> const std::vector<float>& {
        const auto pixels = image.layers.find(layer);
        if (pixels == image.layers.end())
            throw Error(ErrorCode::Conflict, "/reference", "the reference has no layer \"" + layer + "\" to measure");
        return pixels->second;
    };
    if (crosses_)
        for (auto& [layer, state] : states_)
            state.cross = std::make_unique<const CrossMeter>(size, pixels_of(loaded->first, layer),
                                                             pixels_of(*loaded->second, layer));
    ReferenceImage reference = crosses_ ? mean_of(std::move(loaded->first), *loaded->second) : std::move(loaded->first);
    reference_passes_ = reference.passes;
    for (auto& [layer, state] : states_) {
        pixels_of(reference, layer);
        state.meter = std::make_unique<const ErrorMeter>(size, std::move(reference.layers.at(layer)));
        if (const auto error = reference.standard_error.find(layer); error != reference.standard_error.end())
            state.reference_standard_error = std::move(error->second);
    }
}

uint64_t FilmErrors::bytes() const {
    const uint64_t image = 3 * sizeof(float) * size_.pixels();
    uint64_t sum = 0;
    for (const auto& [layer, state] : states_) {
        if (state.meter) sum += 2 * image;  // as given, and encoded for display
        if (state.cross) sum += state.cross->bytes();
        sum += state.reference_standard_error.size() * sizeof(float);
        if (layer == "beauty") sum += ErrorEstimator::bytes_for(size_);
    }
    return sum;
}

std::optional<ErrorEstimate> FilmErrors::estimate(ResolvedFilm& film, const std::string& layer) {
    LayerState& state = states_.at(layer);
    const uint32_t passes = film.film().passes();
    if (state.estimated_passes != passes) {
        const std::vector<float>& variance = film.pass_variance(layer);
        if (variance.empty() && layer != "beauty") return std::nullopt;
        state.estimate = state.estimator.update(passes, film.pixels(layer), variance);
        state.estimated_passes = passes;
    }
    return state.estimate;
}

void FilmErrors::measure(ResolvedFilm& film, const LayerMetric& wanted, CurvePoint& point) {
    const MetricInfo& info = metric_info(wanted.metric);
    const std::string name = wanted.name();
    std::optional<double>& value = point.metrics[name];
    value.reset();
    if (!info.needs_reference) {
        if (const std::optional<ErrorEstimate> found = estimate(film, wanted.layer))
            value = found->estimated_relative_mse;
        return;
    }
    if (crosses_ && is_quadratic(wanted.metric)) {
        const auto figure = figure_of(film.crosswise(wanted.layer, cross_meter(wanted.layer)), wanted.metric);
        if (!figure) return;
        value = figure->value;
        point.intervals[name] = figure->interval;
        return;
    }
    const ErrorMeter& against = meter(wanted.layer);
    const std::vector<double> values = info.costly ? against.measure(wanted.metric, film.pixels(wanted.layer))
                                                   : film.pointwise(wanted.layer, against).values_of(wanted.metric);
    if (!values.empty()) value = values.front();
}

void FilmErrors::measure(ResolvedFilm& film, std::span<const LayerMetric> metrics, CurvePoint& point) {
    for (const LayerMetric& metric : metrics) measure(film, metric, point);
}

}  // namespace photond

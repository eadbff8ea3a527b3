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

std::vector<float> variance_of_mean(std::span<const float> pass_variance, uint32_t passes) {
    std::vector<float> variance(pass_variance.begin(), pass_variance.end());
    for (float& value : variance) value /= static_cast<float>(passes);
    return variance;
}

FilmErrors::FilmErrors(Size2 size, std::optional<ReferenceImage> reference, const std::set<std::string>& layers)
    : size_(size), layers_(layers), has_reference_(reference.has_value()) {
    for (const std::string& layer : layers_) states_[layer];
    if (!reference) return;
    reference_passes_ = reference->passes;
    if (reference->size != size)
        throw Error(ErrorCode::Conflict, "/reference",
                    "the reference is " + size_text(reference->size) + " pixels, the image " + size_text(size));
    for (auto& [layer, state] : states_) {
        const auto pixels = reference->layers.find(layer);
        if (pixels == reference->layers.end())
            throw Error(ErrorCode::Conflict, "/reference", "the reference has no layer \"" + layer + "\" to measure");
        state.meter = std::make_unique<const ErrorMeter>(size, std::move(pixels->second));
        if (const auto error = reference->standard_error.find(layer); error != reference->standard_error.end())
            state.reference_standard_error = std::move(error->second);
    }
}

uint64_t FilmErrors::bytes() const {
    const uint64_t image = 3 * sizeof(float) * size_.pixels();
    uint64_t sum = 0;
    for (const auto& [layer, state] : states_) {
        if (state.meter) sum += 2 * image;  // as given, and encoded for display
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

std::optional<double> FilmErrors::value_of(ResolvedFilm& film, const LayerMetric& wanted) {
    const MetricInfo& info = metric_info(wanted.metric);
    if (!info.needs_reference) {
        const std::optional<ErrorEstimate> found = estimate(film, wanted.layer);
        return found ? std::optional(found->estimated_relative_mse) : std::nullopt;
    }
    const ErrorMeter& against = meter(wanted.layer);
    const std::vector<double> value = info.costly ? against.measure(wanted.metric, film.pixels(wanted.layer))
                                                  : film.pointwise(wanted.layer, against).values_of(wanted.metric);
    return value.empty() ? std::nullopt : std::optional(value.front());
}

void FilmErrors::measure(ResolvedFilm& film, std::span<const LayerMetric> metrics, MetricValues& values) {
    for (const LayerMetric& metric : metrics) values[metric.name()] = value_of(film, metric);
}

}  // namespace photond

#include "server/worker/helper_errors.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "protocol/nearest_name.h"
#include "renderer/error/color_map.h"
#include "renderer/error/cross_meter.h"
#include "renderer/error/error_meter.h"
#include "renderer/error/estimate.h"
#include "renderer/film/exr_file.h"
#include "renderer/film/png_file.h"
#include "server/worker/error_statistics.h"
#include "server/worker/raw_pixels.h"
#include "server/worker/reference_image.h"

namespace photond {

using nlohmann::json;

namespace {

/// An image and what it is compared with, of one size.
struct ImagePair {
    ReferenceImage image, reference;
    std::optional<ReferenceImage> second_reference;
};

/// A text of no length when both have the layer.
std::string missing_layer(const ImagePair& pair, const std::string& layer) {
    const auto missing = [&](const char* which, const ReferenceImage& image) -> std::string {
        if (image.layers.contains(layer)) return "";
        std::string there;
        for (const auto& [name, pixels] : image.layers) there += (there.empty() ? "" : ", ") + name;
        return std::string("the ") + which + " has no layer \"" + layer + "\"; it has " + there;
    };
    std::string text = missing("image", pair.image);
    if (text.empty()) text = missing("reference", pair.reference);
    return text.empty() && pair.second_reference ? missing("second reference", *pair.second_reference) : text;
}

void require_layer(const ImagePair& pair, const std::string& layer, const std::string& pointer) {
    const std::string missing = missing_layer(pair, layer);
    if (!missing.empty()) throw Error(ErrorCode::UnknownName, pointer, missing);
}

/// Faults of the file are put to the field that names it.
ReferenceImage load_source(const ImageSource& source, const char* pointer, uint64_t memory_bytes) {
    try {
        return load_image(source, memory_bytes);
    } catch (const Error& error) {
        throw Error(error.code, pointer, error.what());
    }
}

void check_sizes(const ReferenceImage& image, const ReferenceImage& reference, const std::string& which) {
    if (image.size != reference.size)
        throw Error(ErrorCode::Conflict, "/image",
                    "the image has " + size_text(image.size) + " pixels, " + which + size_text(reference.size));
}

/// Of a request that has both.
template <class Request>
ImagePair load_measured(const Request& asked, uint64_t memory_bytes) {
    ImagePair pair;
    uint64_t taken = 0;
    const auto left = [&](const ReferenceImage& image) {
        taken += image.bytes();
        return memory_bytes - std::min(memory_bytes, taken);
    };
    pair.image = load_source(asked.image, "/image", memory_bytes);
    const ReferenceSource& against = asked.reference;
    pair.reference = load_source(against.first, against.second ? "/references/0" : "/reference", left(pair.image));
    check_sizes(pair.image, pair.reference, "the reference ");
    if (!against.second) return pair;
    pair.second_reference = load_source(*against.second, "/references/1", left(pair.reference));
    check_sizes(pair.image, *pair.second_reference, "the second reference ");
    return pair;
}

/// Likewise, two references as their mean.
template <class Request>
ImagePair load_pair(const Request& asked, uint64_t memory_bytes) {
    ImagePair pair = load_measured(asked, memory_bytes);
    if (pair.second_reference) pair.reference = mean_of(std::move(pair.reference), *pair.second_reference);
    pair.second_reference.reset();
    return pair;
}

// --- Measuring

struct WantedMetric {
    LayerMetric metric;
    std::string pointer;
};

LayerMetric metric_named(const std::string& name, const std::string& pointer) {
    if (const std::optional<LayerMetric> metric = layer_metric_named(name)) return *metric;
    std::vector<std::string> known;
    std::string all;
    for (const MetricInfo& info : kMetrics) {
        known.emplace_back(info.name);
        all += (all.empty() ? "" : ", ") + known.back();
    }
    const std::string near = nearest_name(name.substr(name.find(':') + 1), known);
    throw Error(ErrorCode::UnknownName, pointer,
                "there is no metric \"" + name + "\"; " +
                    (near.empty() ? "there are " + all : "did you mean \"" + near + "\"?"));
}

std::vector<WantedMetric> wanted_metrics(const std::optional<std::vector<std::string>>& names) {
    std::vector<WantedMetric> wanted;
    if (!names) {
        for (const MetricInfo& info : kMetrics)
            if (info.needs_reference && !info.costly) wanted.push_back({{"beauty", info.metric}, "/metrics"});
        return wanted;
    }
    for (size_t i = 0; i < names->size(); ++i) {
        const std::string pointer = "/metrics/" + std::to_string(i);
        wanted.push_back({metric_named((*names)[i], pointer), pointer});
    }
    return wanted;
}

/// A metric's value as the wire has it; null with a reason.
json value_json(const ErrorMeter& meter, std::span<const float> image, Metric metric, std::string& why) {
    // By channel: one that has no value does not take that of the others.
    if (metric == Metric::Bias || metric == Metric::RelativeBias) {
        const PointwiseErrors errors = meter.pointwise(image);
        const std::array<std::optional<double>, 3>& values = errors.channels(metric);
        if (errors.values_of(metric).empty()) meter.measure(metric, image, &why);
        const bool any = std::any_of(values.begin(), values.end(), [](const auto& value) { return value.has_value(); });
        return any ? channels_json(values) : json(nullptr);
    }
    const std::vector<double> values = meter.measure(metric, image, &why);
    if (values.empty()) return nullptr;
    if (metric == Metric::FireflyCount) return static_cast<uint64_t>(values.front());
    if (metric != Metric::Percentiles) return values.front();
    json percentiles = json::object();
    for (size_t i = 0; i < values.size(); ++i) percentiles[std::string(kPercentileNames[i])] = values[i];
    return percentiles;
}

/// Of the image's own passes.
json estimate_json(const ReferenceImage& image, const std::string& layer, std::string& why) {
    const auto standard_error = image.standard_error.find(layer);
    if (standard_error == image.standard_error.end()) {
        why = "the image's noise is not known";
        return nullptr;
    }
    std::vector<float> variance = standard_error->second;
    for (float& value : variance) value *= value;
    const std::optional<double> estimate = expected_relative_mse(image.layers.at(layer), variance);
    if (!estimate) why = "the mean of the image is 0, or nothing is known of its noise";
    return estimate ? json(*estimate) : json(nullptr);
}

uint64_t count_not_finite(std::span<const float> values) {
    return static_cast<uint64_t>(
        std::count_if(values.begin(), values.end(), [](float value) { return !std::isfinite(value); }));
}

/// One layer: its meter, and the reference with noise of its own where that is known.
struct MeasuredLayer {
    std::unique_ptr<const ErrorMeter> meter;
    std::unique_ptr<const CrossMeter> cross;  // of two references; `meter` then has their mean
    std::vector<float> noisy_reference;
};

class Measuring {
public:
    explicit Measuring(ImagePair pair) : pair_(std::move(pair)) {}

    void add(const WantedMetric& wanted) {
        const auto& [layer, metric] = wanted.metric;
        const std::string name = wanted.metric.name();
        require_layer(pair_, layer, wanted.pointer);
        std::string why;
        if (!metric_info(metric).needs_reference) {
            values_[name] = estimate_json(pair_.image, layer, why);
            reference_error_[name] = nullptr;
        } else if (const MeasuredLayer& measured = layer_of(layer); measured.cross && is_quadratic(metric)) {
            add_cross(name, *measured.cross, pair_.image.layers.at(layer), metric, why);
        } else {
            values_[name] = value_json(*measured.meter, pair_.image.layers.at(layer), metric, why);
            // Fireflies are an image's own: added noise makes none, and what the reference has explains none.
            const bool known = !measured.noisy_reference.empty() && metric != Metric::FireflyCount;
            std::string why_not;  // as for the image
            reference_error_[name] =
                known ? value_json(*measured.meter, measured.noisy_reference, metric, why_not) : json(nullptr);
        }
        if (!why.empty()) note(name + ": " + why);
    }

    MeasureReply result() {
        const bool known = std::any_of(reference_error_.begin(), reference_error_.end(),
                                       [](const json& value) { return !value.is_null(); });
        if (known)
            for (const std::string& warning : noise_warnings(values_, intervals_, reference_error_)) note(warning);
        return {values_, pair_.second_reference ? intervals_ : json(nullptr), known ? reference_error_ : json(nullptr),
                notes_};
    }

private:
    /// A quadratic metric, in which the references' noise has no part.
    void add_cross(const std::string& name, const CrossMeter& meter, std::span<const float> image, Metric metric,
                   std::string& why) {
        values_[name] = intervals_[name] = reference_error_[name] = nullptr;
        const CrossErrors errors = meter.measure(image);
        const std::optional<CrossFigure> figure = figure_of(errors, metric);
        if (!figure) {
            why = errors.mse ? "the mean of the references is 0" : "no value is finite in all three images";
            return;
        }
        intervals_[name] = {figure->interval.least, figure->interval.greatest};
        if (figure->value)
            values_[name] = *figure->value;
        else
            why = kRootBelowZero;
        if (figure->denominators == Denominators::Neighbours) note(name + ": " + std::string(kDividedByNeighbours));
    }

    const MeasuredLayer& layer_of(const std::string& layer) {
        const auto [entry, is_new] = layers_.try_emplace(layer);
        if (!is_new) return entry->second;
        MeasuredLayer& measured = entry->second;
        std::vector<float>& reference = pair_.reference.layers.at(layer);
        note_not_finite(layer, pair_.image.layers.at(layer), reference);
        if (pair_.second_reference) {
            use_both(measured, layer, std::move(reference));
            return measured;
        }
        measured.meter = std::make_unique<const ErrorMeter>(pair_.image.size, std::move(reference));
        const auto standard_error = pair_.reference.standard_error.find(layer);
        if (standard_error != pair_.reference.standard_error.end())
            measured.noisy_reference =
                with_own_noise(measured.meter->reference(), standard_error->second, kReferenceNoiseSeed);
        else
            note("the reference's own noise is not known for " + layer);
        return measured;
    }

    /// The first of two is as far from their mean as another mean of two would be.
    void use_both(MeasuredLayer& measured, const std::string& layer, std::vector<float> reference) {
        const std::vector<float>& second = pair_.second_reference->layers.at(layer);
        if (reference == second)
            throw Error(ErrorCode::Conflict, "/references/1",
                        "the references are one image in " + layer + ": they must have noise of their own");
        measured.cross = std::make_unique<const CrossMeter>(pair_.image.size, reference, second);
        const std::span<const float> mean = measured.cross->mean_reference();
        measured.meter =
            std::make_unique<const ErrorMeter>(pair_.image.size, std::vector<float>(mean.begin(), mean.end()));
        measured.noisy_reference = std::move(reference);
    }

    void note_not_finite(const std::string& layer, std::span<const float> image, std::span<const float> reference) {
        const uint64_t of_image = count_not_finite(image), of_reference = count_not_finite(reference);
        if (of_image + of_reference == 0) return;
        note(layer + ": " + std::to_string(of_image) + " values of the image and " + std::to_string(of_reference) +
             " of the reference are NaN or infinite; means leave them out, FLIP takes them for 0");
    }

    void note(const std::string& text) { notes_.push_back(text); }

    ImagePair pair_;
    std::map<std::string, MeasuredLayer> layers_;
    json values_ = json::object(), intervals_ = json::object(), reference_error_ = json::object();
    std::vector<std::string> notes_;
};

// --- Pictures

FlipRange flip_range_named(const std::string& name) {
    if (name == "ldr") return FlipRange::Ldr;
    if (name == "hdr") return FlipRange::Hdr;
    throw Error(ErrorCode::UnknownName, "/range", "range \"" + name + "\" is neither ldr nor hdr");
}

struct SizedFlipMap {
    Size2 size;
    FlipMap map;
};

template <class Request>
SizedFlipMap measure_flip(const Request& asked, uint64_t memory_bytes) {
    const FlipRange range = flip_range_named(asked.range);
    const ImagePair pair = load_pair(asked, memory_bytes);
    require_layer(pair, asked.layer, "/layer");
    return {
        pair.image.size,
        Flip(pair.image.size, pair.reference.layers.at(asked.layer), range).measure(pair.image.layers.at(asked.layer))};
}

/// 0 at kLeastMappedError and below, 1 at kGreatestMappedError and above.
float on_log_scale(double error) {
    static const double decades = std::log10(kGreatestMappedError / kLeastMappedError);
    if (std::isnan(error)) return std::numeric_limits<float>::quiet_NaN();
    if (error <= kLeastMappedError) return 0;
    return static_cast<float>(std::min(1.0, std::log10(error / kLeastMappedError) / decades));
}

}  // namespace

MeasureReply measure_images(const MeasureRequest& asked, uint64_t memory_bytes) {
    const std::vector<WantedMetric> wanted = wanted_metrics(asked.metrics);
    Measuring measuring(load_measured(asked, memory_bytes));
    for (const WantedMetric& metric : wanted) measuring.add(metric);
    return measuring.result();
}

void encode_difference(const EncodeDifferenceRequest& asked, uint64_t memory_bytes) {
    ImagePair pair = load_pair(asked, memory_bytes);
    std::vector<ImageLayer> differences;
    const auto add = [&](const std::string& layer) {
        if (!missing_layer(pair, layer).empty()) return;
        std::vector<float> pixels = std::move(pair.image.layers[layer]);
        const std::vector<float>& reference = pair.reference.layers[layer];
        for (size_t i = 0; i < pixels.size(); ++i) pixels[i] -= reference[i];
        differences.push_back({channel_names(layer), std::move(pixels)});
    };
    add("beauty");
    for (const LayerInfo& info : kLayers) add(std::string(info.name));
    write_exr(pair.image.size, std::move(differences), Precision::Float, {}, asked.out);
}

EncodedReply encode_flip(const EncodeFlipRequest& asked, uint64_t memory_bytes) {
    const SizedFlipMap flip = measure_flip(asked, memory_bytes);
    write_png(flip.size, color_mapped(flip.map.values), asked.out);
    EncodedReply reply;
    reply.mean = flip.map.mean;
    return reply;
}

EncodedReply encode_flip_map(const EncodeFlipMapRequest& asked, uint64_t memory_bytes) {
    const Precision precision = precision_named(asked.precision);
    const SizedFlipMap flip = measure_flip(asked, memory_bytes);
    EncodedReply reply = write_raw_pixels(flip.size, 1, flip.map.values, precision, asked.out);
    reply.mean = flip.map.mean;
    return reply;
}

void encode_error_map(const EncodeErrorMapRequest& asked, uint64_t memory_bytes) {
    ImagePair pair = load_pair(asked, memory_bytes);
    require_layer(pair, asked.layer, "/layer");
    const ErrorMeter meter(pair.image.size, std::move(pair.reference.layers.at(asked.layer)));
    const std::vector<double> errors = meter.relative_errors(pair.image.layers.at(asked.layer));
    std::vector<float> shown(pair.image.size.pixels(), std::numeric_limits<float>::quiet_NaN());
    std::transform(errors.begin(), errors.end(), shown.begin(), on_log_scale);
    write_png(pair.image.size, color_mapped(shown), asked.out);
}

}  // namespace photond

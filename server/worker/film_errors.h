#pragma once
// The error of one film, by metric name: its layers against those of a reference, and what its own passes tell.

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "renderer/error/cross_meter.h"
#include "renderer/error/curve.h"
#include "renderer/error/error_meter.h"
#include "renderer/error/estimate.h"
#include "renderer/error/metric.h"
#include "renderer/film/film.h"
#include "server/worker/reference_image.h"

namespace photond {

/// "640 x 360".
std::string size_text(Size2 size);

/// The layers of a film at one moment and what a sweep over them finds, made when first asked for. Borrows the film.
class ResolvedFilm {
public:
    explicit ResolvedFilm(const Film& film) : film_(film) {}

    const Film& film() const { return film_; }
    /// "beauty" or a layer of radiance that the film has.
    const std::vector<float>& pixels(const std::string& layer);
    /// Between passes, of one pass's value; empty where it is not known (emitted, caustic, a single pass).
    const std::vector<float>& pass_variance(const std::string& layer);
    /// By the layer's meter, which must be the same every time.
    const PointwiseErrors& pointwise(const std::string& layer, const ErrorMeter& meter);
    const CrossErrors& crosswise(const std::string& layer, const CrossMeter& meter);

private:
    const Film& film_;
    std::map<std::string, std::vector<float>> pixels_, pass_variance_;
    std::map<std::string, PointwiseErrors> sweeps_;
    std::map<std::string, CrossErrors> cross_sweeps_;
};

/// The variance of the mean of n passes.
std::vector<float> variance_of_mean(std::span<const float> pass_variance, uint32_t passes);

/// Metrics that are a distance from the reference: one number, 0 for the reference itself.
constexpr bool is_distance(const MetricInfo& info) {
    return info.needs_reference && info.values == 1 && info.metric != Metric::FireflyCount;
}

class FilmErrors {
public:
    /// `layers`: those to be measured, "beauty" among them. Throws ErrorCode::Conflict when the reference has another
    /// size or lacks a layer. Layers of the reference that are not measured are dropped.
    FilmErrors(Size2 size, std::optional<LoadedReference> reference, const std::set<std::string>& layers);

    bool has_reference() const { return has_reference_; }
    std::optional<uint32_t> reference_passes() const { return reference_passes_; }
    const std::set<std::string>& layers() const { return layers_; }
    /// Whether that is two films: quadratic metrics are then cross estimates.
    bool crosses() const { return crosses_; }
    /// Only with a reference; of two films against their mean.
    const ErrorMeter& meter(const std::string& layer) const { return *of(layer).meter; }
    /// Only where it crosses().
    const CrossMeter& cross_meter(const std::string& layer) const { return *of(layer).cross; }
    /// Of the reference's values; empty when it is not known.
    const std::vector<float>& reference_standard_error(const std::string& layer) const {
        return of(layer).reference_standard_error;
    }
    /// Bytes it keeps from one measurement to the next, FLIP's features apart.
    uint64_t bytes() const;

    /// Adds the values of metrics that are one number each, and the intervals of those that have one. Films are given
    /// as their passes rise.
    void measure(ResolvedFilm& film, std::span<const LayerMetric> metrics, CurvePoint& point);
    /// What the passes tell of a layer; empty where they tell nothing.
    std::optional<ErrorEstimate> estimate(ResolvedFilm& film, const std::string& layer);
    /// Of the beauty, as estimated last.
    std::optional<double> last_standard_error_scale() const {
        const std::optional<ErrorEstimate>& last = of("beauty").estimate;
        return last ? std::optional(last->standard_error_scale) : std::nullopt;
    }

private:
    struct LayerState {
        std::unique_ptr<const ErrorMeter> meter;
        std::unique_ptr<const CrossMeter> cross;
        std::vector<float> reference_standard_error;
        ErrorEstimator estimator;
        uint32_t estimated_passes = 0;
        std::optional<ErrorEstimate> estimate;  // after so many passes
    };
    const LayerState& of(const std::string& layer) const { return states_.at(layer); }
    void measure(ResolvedFilm& film, const LayerMetric& wanted, CurvePoint& point);

    Size2 size_;
    std::set<std::string> layers_;
    bool has_reference_ = false, crosses_ = false;
    std::optional<uint32_t> reference_passes_;
    std::map<std::string, LayerState> states_;
};

}  // namespace photond

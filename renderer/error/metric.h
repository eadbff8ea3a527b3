#pragma once
// The names of the error measures (conventions.md, "Error"): one table, read by requests, statistics and reports.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace photond {

enum class Metric : uint8_t {
    RelativeMse,
    Mse,
    Rmse,
    Mae,
    Smape,
    Rmse8bit,
    FittedRmse,
    FittedRelativeMse,
    FlipLdr,
    FlipHdr,
    Bias,
    RelativeBias,
    Percentiles,
    FireflyCount,
    EstimatedRelativeMse,
};

struct MetricInfo {
    Metric metric;
    std::string_view name;
    std::string_view title;  // for tables
    uint32_t values;         // 1: a number; 3: one a channel; 4: percentiles 50, 90, 99, 100
    bool needs_reference;    // else it is estimated from the passes
    bool costly;             // not one sweep over the pixels: measured when asked for by name
    /// Where the error is nothing but independent noise it falls with the passes to this power; 0: no law says how.
    double slope;
    std::string_view text;
    std::string_view line = {};  // of the usual ones, for who does not know them
};

inline constexpr auto kMetrics = std::to_array<MetricInfo>({
    {Metric::RelativeMse, "relative_mse", "Relative MSE", 1, true, false, -1,
     "mean of (x - r)^2 / (r^2 + 0.01 m^2), m the mean of r",
     "squared error over the square of the reference; the usual measure of noise"},
    {Metric::Mse, "mse", "MSE", 1, true, false, -1, "mean squared difference"},
    {Metric::Rmse, "rmse", "RMSE", 1, true, false, -0.5, "root of the mean squared difference",
     "root of the mean squared difference"},
    {Metric::Mae, "mae", "MAE", 1, true, false, -0.5, "mean absolute difference"},
    {Metric::Smape, "smape", "SMAPE", 1, true, false, 0, "mean of 2 |x - r| / (|x| + |r| + 0.1 m)",
     "difference over the sum, robust against bright pixels"},
    {Metric::Rmse8bit, "rmse_8bit", "RMSE, 8 bit", 1, true, false, 0,
     "RMS difference per channel at 8-bit sRGB, the three added", "at 8-bit sRGB, as papers of that time have it"},
    {Metric::FittedRmse, "fitted_rmse", "RMSE, fitted", 1, true, false, -0.5,
     "rmse after the exposure (a factor on x) that makes it least"},
    {Metric::FittedRelativeMse, "fitted_relative_mse", "Relative MSE, fitted", 1, true, false, -1,
     "relative_mse after the exposure that makes it least"},
    {Metric::FlipLdr, "flip_ldr", "LDR-FLIP", 1, true, true, 0, "mean LDR-FLIP, 0 to 1"},
    {Metric::FlipHdr, "flip_hdr", "HDR-FLIP", 1, true, true, 0, "mean HDR-FLIP, 0 to 1",
     "how different it looks, 0 to 1 (HDR-FLIP)"},
    {Metric::Bias, "bias", "Bias, R G B", 3, true, false, 0, "mean of x - r, by channel"},
    {Metric::RelativeBias, "relative_bias", "Relative bias, R G B", 3, true, false, 0,
     "bias over the channel's mean of r"},
    {Metric::Percentiles, "percentiles", "Percentiles", 4, true, true, 0,
     "50, 90, 99 and 100 % of the pixels' relative error"},
    {Metric::FireflyCount, "firefly_count", "Fireflies", 1, true, true, 0,
     "pixels over 100 times their neighbourhood's median"},
    {Metric::EstimatedRelativeMse, "estimated_relative_mse", "Relative MSE, estimated", 1, false, false, -1,
     "relative_mse expected from the passes", "estimated from the passes; needs no reference"},
});
constexpr const MetricInfo& metric_info(Metric metric) { return kMetrics[static_cast<size_t>(metric)]; }
inline constexpr std::array<size_t, 4> kPercentiles{50, 90, 99, 100};
inline constexpr std::array<std::string_view, 4> kPercentileNames{"50", "90", "99", "100"};

/// A metric of one layer: "relative_mse" is of the beauty, "indirect:relative_mse" of the indirect light.
struct LayerMetric {
    std::string layer = "beauty";
    Metric metric = Metric::RelativeMse;

    std::string name() const {
        const std::string metric_name(metric_info(metric).name);
        return layer == "beauty" ? metric_name : layer + ":" + metric_name;
    }
    bool operator==(const LayerMetric&) const = default;
};

/// Empty when there is no metric of that name; whether the layer exists is the caller's to know.
inline std::optional<LayerMetric> layer_metric_named(std::string_view name) {
    LayerMetric found;
    if (const size_t colon = name.find(':'); colon != std::string_view::npos) {
        found.layer = name.substr(0, colon);
        name.remove_prefix(colon + 1);
        if (found.layer.empty()) return std::nullopt;
    }
    for (const MetricInfo& info : kMetrics)
        if (info.name == name) {
            found.metric = info.metric;
            return found;
        }
    return std::nullopt;
}

}  // namespace photond

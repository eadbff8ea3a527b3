#pragma once
// Error against time on logarithmic axes, as an SVG that stands in a page.

#include <optional>
#include <string>
#include <vector>

#include "server/comparisons/table.h"

namespace photond {

struct PlotSeries {
    std::string name;
    std::vector<MeanPoint> points;     // by rising seconds
    std::optional<double> floor = {};  // floor_of(): a dotted line
};

struct Plot {
    std::string title, error_axis;
    std::vector<PlotSeries> series;
    std::optional<double> reference_noise;  // a dashed line
};

/// Lines with their 95 % bands, whiskers for what the references' noise leaves open, arrows down from upper bounds
/// where an error is not positive (MeanError::drawn()), which lines leave out; axes with 1-2-5 ticks, a title to hover
/// on each point. Colours and dashes come from the page's classes "line-N" (styles_of_series()). Empty when no series
/// has a point.
std::string log_log_plot(const Plot& plot);

/// A stroke as it stands in the legend.
std::string legend_stroke(size_t series);

/// Colours told apart by the colour-blind [Okabe and Ito 2008], Color Universal Design; from the ninth series on with
/// another dash pattern each eight.
std::string styles_of_series(size_t count);

}  // namespace photond

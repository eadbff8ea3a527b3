#pragma once
// A figure of a sequence by its frames, as an SVG that stands in a page.

#include <string>
#include <vector>

#include "renderer/error/interval.h"

namespace photond {

struct FrameSeries {
    struct Point {
        double frame = 0;
        double value = 0;
        Interval interval;  // holds it
    };
    std::string name;
    std::vector<Point> points;  // by rising frames
};

struct FramePlot {
    std::string title, axis;
    bool logarithmic = true;  // values that are not positive are drawn as upper bounds then
    std::vector<FrameSeries> series;
};

/// Lines, whiskers for the intervals, a title to hover on each point; of an axis that is not logarithmic a line at 0.
/// Colours as log_log_plot() has them. Empty when nothing can be drawn.
std::string frame_plot(const FramePlot& asked);

}  // namespace photond

#include "server/comparisons/frame_plot.h"

#include <algorithm>

#include "server/comparisons/plot_parts.h"
#include "server/comparisons/report_text.h"

namespace photond {
namespace {

bool is_bound(const FramePlot& asked, const FrameSeries::Point& point) {
    return asked.logarithmic && !(point.value > 0);
}

plot::Range values_of(const FramePlot& asked) {
    plot::Range range;
    for (const FrameSeries& series : asked.series)
        for (const FrameSeries::Point& point : series.points) {
            const auto& [least, greatest] = point.interval;
            if (!asked.logarithmic)
                range.add(least), range.add(greatest);
            else if (greatest > 0)
                range.add(greatest), range.add(std::max(point.value, plot::kSeenBelow * greatest));
        }
    if (!asked.logarithmic && !range.empty()) range.add(0);
    return range;
}

/// "a: 0.012 at frame 3 (0.011 – 0.013)"
std::string title_of(const FrameSeries& series, const FrameSeries::Point& point) {
    return series.name + ": " + short_number(point.value) + " at frame " + short_number(point.frame) + " (" +
           range(point.interval.least, point.interval.greatest, short_number) + ")";
}

std::string series_svg(const FramePlot& asked, size_t index, const plot::Axis& x, const plot::Axis& y) {
    const FrameSeries& series = asked.series[index];
    const std::string kind = "line-" + std::to_string(index);
    std::string lines, marks, points;
    for (const FrameSeries::Point& point : series.points) {
        const double across = x.at(point.frame);
        if (!is_bound(asked, point)) {
            points += plot::point(x, y, point.frame, point.value);
            marks += plot::line("whisker " + kind, across, y.at_within(point.interval.least), across,
                                y.at_within(point.interval.greatest)) +
                     plot::dot(kind, across, y.at_within(point.value), title_of(series, point));
            continue;
        }
        lines += plot::curve(kind, points, series.name);
        points.clear();
        if (point.interval.greatest > 0)
            marks += plot::upper_bound(kind, across, y.at_within(point.interval.greatest), title_of(series, point));
    }
    return lines + plot::curve(kind, points, series.name) + marks;
}

}  // namespace

std::string frame_plot(const FramePlot& asked) {
    const plot::Range values = values_of(asked);
    if (values.empty()) return "";
    plot::Range frames;
    for (const FrameSeries& series : asked.series)
        for (const FrameSeries::Point& point : series.points) frames.add(point.frame);
    const plot::Axis x = frames.linear_axis(plot::kLeft, plot::kWidth - plot::kRight);
    const double bottom = plot::kHeight - plot::kBottom;
    const plot::Axis y =
        asked.logarithmic ? values.logarithmic_axis(bottom, plot::kTop) : values.linear_axis(bottom, plot::kTop);
    std::string svg = plot::begin(asked.title) + plot::axes(x, y, "frame", asked.axis);
    if (!asked.logarithmic) svg += plot::line("floor", x.from, y.at(0), x.to, y.at(0));
    for (size_t i = 0; i < asked.series.size(); ++i) svg += series_svg(asked, i, x, y);
    return svg + "</svg>";
}

}  // namespace photond

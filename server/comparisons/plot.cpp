#include "server/comparisons/plot.h"

#include <algorithm>
#include <array>

#include "server/comparisons/plot_parts.h"
#include "server/comparisons/report_text.h"

namespace photond {
namespace {

constexpr double kFloorBelow = 100;  // the reference's noise is shown when not further below the data

std::string band(const PlotSeries& series, size_t index, const plot::Axis& x, const plot::Axis& y) {
    std::string there, back;
    for (const MeanPoint& point : series.points) {
        const SeedMean& error = point.mean.error;
        if (!error.low || !error.high) continue;
        there += plot::point(x, y, point.seconds, *error.high);
        back.insert(0, plot::point(x, y, point.seconds, *error.low));
    }
    if (there.empty()) return "";
    return "<polygon class=\"band line-" + std::to_string(index) + "\" points=\"" + there + back + "\"/>";
}

/// Through the points that are errors, broken where one is a bound.
std::string lines(const PlotSeries& series, const std::string& name, const plot::Axis& x, const plot::Axis& y) {
    std::string svg, points;
    const auto end = [&] {
        svg += plot::curve(name, points, series.name);
        points.clear();
    };
    for (const MeanPoint& point : series.points) {
        if (point.mean.is_bound())
            end();
        else
            points += plot::point(x, y, point.seconds, point.mean.error.mean);
    }
    end();
    return svg;
}

/// "a: 0.012 after 3 s (95 %: 0.01 – 0.014; references: 0.011 – 0.013)"
std::string point_title(const PlotSeries& series, const MeanPoint& point) {
    const MeanError& mean = point.mean;
    std::string known = interval(mean.error, short_number);
    if (!known.empty()) known.insert(0, "95 %: ");
    if (mean.interval)
        known += (known.empty() ? "references: " : "; references: ") +
                 range(mean.interval->least, mean.interval->greatest, short_number);
    return series.name + ": " + short_number(mean.error.mean) + " after " + short_seconds(point.seconds) +
           (known.empty() ? "" : " (" + known + ")");
}

std::string marks(const PlotSeries& series, const std::string& name, const plot::Axis& x, const plot::Axis& y) {
    std::string svg;
    for (const MeanPoint& point : series.points) {
        const auto drawn = point.mean.drawn();
        if (!drawn) continue;
        const double across = x.at(point.seconds), at = y.at_within(*drawn);
        const std::string title = point_title(series, point);
        if (point.mean.is_bound()) {
            svg += plot::upper_bound(name, across, at, title);
            continue;
        }
        if (point.mean.interval) {
            const Interval& ends = *point.mean.interval;
            svg += plot::line("whisker " + name, across, y.at_within(ends.least), across, y.at_within(ends.greatest));
        }
        svg += plot::dot(name, across, at, title);
    }
    return svg;
}

std::string curve(const PlotSeries& series, size_t index, const plot::Axis& x, const plot::Axis& y) {
    const std::string name = "line-" + std::to_string(index);
    return lines(series, name, x, y) + marks(series, name, x, y);
}

std::string floor_line(const PlotSeries& series, size_t index, const plot::Axis& x, const plot::Axis& y) {
    if (!series.floor) return "";
    const double at = y.at(*series.floor);
    return plot::line("bias-floor line-" + std::to_string(index), x.from, at, x.to, at) +
           plot::text_at(x.from + 6, at - 6, "start", series.name + ": no less than " + short_number(*series.floor));
}

}  // namespace

std::string log_log_plot(const Plot& asked) {
    plot::Range seconds, errors;
    for (const PlotSeries& series : asked.series)
        for (const MeanPoint& point : series.points)
            if (const auto drawn = point.mean.drawn()) {
                seconds.add(point.seconds);
                errors.add(std::max(*drawn, plot::kSeenBelow * point.mean.upper_end()));
            }
    if (errors.empty()) return "";
    for (const PlotSeries& series : asked.series)
        if (series.floor) errors.add(*series.floor);
    // Wide bands of two or three seeds are cut at the frame; the curves decide what is seen.
    const bool floor = asked.reference_noise && *asked.reference_noise > 0 &&
                       *asked.reference_noise * kFloorBelow > errors.low && *asked.reference_noise <= errors.high;
    if (floor) errors.add(*asked.reference_noise);
    const plot::Axis x = seconds.logarithmic_axis(plot::kLeft, plot::kWidth - plot::kRight);
    const plot::Axis y = errors.logarithmic_axis(plot::kHeight - plot::kBottom, plot::kTop);
    std::string svg = plot::begin(asked.title) + plot::axes(x, y, "seconds on the job's clock", asked.error_axis);
    for (size_t i = 0; i < asked.series.size(); ++i) svg += band(asked.series[i], i, x, y);
    if (floor) {
        const double at = y.at(*asked.reference_noise);
        svg += plot::line("floor", x.from, at, x.to, at) +
               plot::text_at(x.to - 4, at - 6, "end",
                             "the reference's own noise, " + short_number(*asked.reference_noise));
    }
    for (size_t i = 0; i < asked.series.size(); ++i) svg += curve(asked.series[i], i, x, y);
    for (size_t i = 0; i < asked.series.size(); ++i) svg += floor_line(asked.series[i], i, x, y);
    return svg + "</svg>";
}

std::string legend_stroke(size_t series) {
    return "<svg class=\"stroke\" viewBox=\"0 0 34 10\" aria-hidden=\"true\"><line class=\"curve line-" +
           std::to_string(series) + "\" x1=\"1\" y1=\"5\" x2=\"33\" y2=\"5\"/></svg>";
}

std::string styles_of_series(size_t count) {
    // Of Okabe and Ito's eight, yellow is left out: it is lost on white. Black becomes a grey that both papers bear.
    static constexpr std::array kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                        "#e69f00", "#56b4e9", "#808080", "#8c6bb1"};
    static constexpr std::array kDashes{"none", "7 4", "2 3", "10 3 2 3", "14 4", "4 2 1 2"};
    std::string css;
    for (size_t i = 0; i < count; ++i) {
        css += ".line-" + std::to_string(i) + "{--c:" + kColors[i % kColors.size()] + "}";
        if (i >= kColors.size())
            css += ".curve.line-" + std::to_string(i) +
                   "{stroke-dasharray:" + kDashes[i / kColors.size() % kDashes.size()] + "}";
    }
    return css;
}

}  // namespace photond

#include "server/comparisons/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "server/comparisons/levels.h"
#include "server/comparisons/report_text.h"

namespace photond {
namespace {

constexpr double kWidth = 860, kHeight = 440;  // of the view box
constexpr double kLeft = 78, kRight = 14, kTop = 12, kBottom = 50;
constexpr double kMargin = 1.12;     // factor beyond the data on each side
constexpr size_t kMostLabels = 10;   // of an axis
constexpr double kFloorBelow = 100;  // the reference's noise is shown when not further below the data
/// An error is seen down to this share of its upper end: a figure near 0 by luck is not to draw the axis down.
constexpr double kSeenBelow = 0.1;

struct Range {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    void add(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

std::string fixed(double value) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.2f", value);
    return text.data();
}

/// One axis: from values to places in the view box.
struct Axis {
    double low, high, from, to;
    double at(double value) const { return from + (to - from) * std::log(value / low) / std::log(high / low); }
};

std::vector<double> labelled(const std::vector<double>& ticks) {
    if (ticks.size() <= kMostLabels) return ticks;
    std::vector<double> decades;  // 1, 10, 100 ...
    for (const double tick : ticks)
        if (const double exponent = std::log10(tick); std::abs(exponent - std::round(exponent)) < 1e-9)
            decades.push_back(tick);
    return decades;
}

std::string text_at(double x, double y, const char* anchor, const std::string& text, const char* more = "") {
    return "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
           escaped(text) + "</text>";
}

std::string line(const char* kind, double x0, double y0, double x1, double y1) {
    return std::string("<line class=\"") + kind + "\" x1=\"" + fixed(x0) + "\" y1=\"" + fixed(y0) + "\" x2=\"" +
           fixed(x1) + "\" y2=\"" + fixed(y1) + "\"/>";
}

std::string axes(const Axis& x, const Axis& y, const std::string& error_axis) {
    std::string svg;
    const std::vector<double> times = round_levels(x.low, x.high), errors = round_levels(y.low, y.high);
    for (const double time : times) svg += line("grid", x.at(time), y.from, x.at(time), y.to);
    for (const double error : errors) svg += line("grid", x.from, y.at(error), x.to, y.at(error));
    for (const double time : labelled(times)) svg += text_at(x.at(time), y.from + 18, "middle", short_number(time));
    for (const double error : labelled(errors)) svg += text_at(x.from - 8, y.at(error) + 4, "end", short_number(error));
    svg += line("axis", x.from, y.from, x.to, y.from) + line("axis", x.from, y.from, x.from, y.to);
    svg += text_at((x.from + x.to) / 2, kHeight - 8, "middle", "seconds on the job's clock");
    const double middle = (y.from + y.to) / 2;
    return svg +
           text_at(16, middle, "middle", error_axis, (" transform=\"rotate(-90 16 " + fixed(middle) + ")\"").c_str());
}

std::string place(const Axis& x, const Axis& y, double seconds, double error) {
    return fixed(x.at(seconds)) + "," + fixed(y.at(std::clamp(error, y.low, y.high))) + " ";
}

std::string band(const PlotSeries& series, size_t index, const Axis& x, const Axis& y) {
    std::string there, back;
    for (const MeanPoint& point : series.points) {
        const SeedMean& error = point.mean.error;
        if (!error.low || !error.high) continue;
        there += place(x, y, point.seconds, *error.high);
        back.insert(0, place(x, y, point.seconds, *error.low));
    }
    if (there.empty()) return "";
    return "<polygon class=\"band line-" + std::to_string(index) + "\" points=\"" + there + back + "\"/>";
}

/// Through the points that are errors, broken where one is a bound.
std::string lines(const PlotSeries& series, const std::string& name, const Axis& x, const Axis& y) {
    std::string svg, points;
    const auto end = [&] {
        if (!points.empty())
            svg += "<polyline class=\"curve " + name + "\" points=\"" + points + "\"><title>" + escaped(series.name) +
                   "</title></polyline>";
        points.clear();
    };
    for (const MeanPoint& point : series.points) {
        if (point.mean.is_bound())
            end();
        else
            points += place(x, y, point.seconds, point.mean.error.mean);
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
    return escaped(series.name + ": " + short_number(mean.error.mean) + " after " + short_seconds(point.seconds) +
                   (known.empty() ? "" : " (" + known + ")"));
}

std::string marks(const PlotSeries& series, const std::string& name, const Axis& x, const Axis& y) {
    std::string svg;
    for (const MeanPoint& point : series.points) {
        const auto drawn = point.mean.drawn();
        if (!drawn) continue;
        const double across = x.at(point.seconds), at = y.at(std::clamp(*drawn, y.low, y.high));
        const std::string title = "><title>" + point_title(series, point) + "</title>";
        if (point.mean.is_bound()) {
            svg += "<path class=\"bound " + name + "\" d=\"M" + fixed(across - 5) + " " + fixed(at) +
                   "h10m-5 0v15m-4 -5l4 5l4 -5\"" + title + "</path>";
            continue;
        }
        if (point.mean.interval) {
            const Interval& ends = *point.mean.interval;
            svg += line(("whisker " + name).c_str(), across, y.at(std::clamp(ends.least, y.low, y.high)), across,
                        y.at(std::clamp(ends.greatest, y.low, y.high)));
        }
        svg += "<circle class=\"point " + name + "\" cx=\"" + fixed(across) + "\" cy=\"" + fixed(at) + "\" r=\"3\"" +
               title + "</circle>";
    }
    return svg;
}

std::string curve(const PlotSeries& series, size_t index, const Axis& x, const Axis& y) {
    const std::string name = "line-" + std::to_string(index);
    return lines(series, name, x, y) + marks(series, name, x, y);
}

std::string floor_line(const PlotSeries& series, size_t index, const Axis& x, const Axis& y) {
    if (!series.floor) return "";
    const double at = y.at(*series.floor);
    return line(("bias-floor line-" + std::to_string(index)).c_str(), x.from, at, x.to, at) +
           text_at(x.from + 6, at - 6, "start", series.name + ": no less than " + short_number(*series.floor));
}

}  // namespace

std::string log_log_plot(const Plot& plot) {
    Range seconds, errors;
    for (const PlotSeries& series : plot.series)
        for (const MeanPoint& point : series.points)
            if (const auto drawn = point.mean.drawn()) {
                seconds.add(point.seconds);
                errors.add(std::max(*drawn, kSeenBelow * point.mean.upper_end()));
            }
    if (errors.high == 0) return "";
    for (const PlotSeries& series : plot.series)
        if (series.floor) errors.add(*series.floor);
    // Wide bands of two or three seeds are cut at the frame; the curves decide what is seen.
    const bool floor = plot.reference_noise && *plot.reference_noise > 0 &&
                       *plot.reference_noise * kFloorBelow > errors.low && *plot.reference_noise <= errors.high;
    if (floor) errors.add(*plot.reference_noise);
    const Axis x{seconds.low / kMargin, seconds.high * kMargin, kLeft, kWidth - kRight};
    const Axis y{errors.low / kMargin, errors.high * kMargin, kHeight - kBottom, kTop};
    std::string svg = "<svg class=\"plot\" viewBox=\"0 0 " + fixed(kWidth) + " " + fixed(kHeight) +
                      "\" role=\"img\" aria-label=\"" + escaped(plot.title) + "\">" + axes(x, y, plot.error_axis);
    for (size_t i = 0; i < plot.series.size(); ++i) svg += band(plot.series[i], i, x, y);
    if (floor) {
        const double at = y.at(*plot.reference_noise);
        svg += line("floor", x.from, at, x.to, at) +
               text_at(x.to - 4, at - 6, "end", "the reference's own noise, " + short_number(*plot.reference_noise));
    }
    for (size_t i = 0; i < plot.series.size(); ++i) svg += curve(plot.series[i], i, x, y);
    for (size_t i = 0; i < plot.series.size(); ++i) svg += floor_line(plot.series[i], i, x, y);
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

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
        if (!point.error.low || !point.error.high) continue;
        there += place(x, y, point.seconds, *point.error.high);
        back.insert(0, place(x, y, point.seconds, *point.error.low));
    }
    if (there.empty()) return "";
    return "<polygon class=\"band line-" + std::to_string(index) + "\" points=\"" + there + back + "\"/>";
}

std::string curve(const PlotSeries& series, size_t index, const Axis& x, const Axis& y) {
    const std::string name = "line-" + std::to_string(index);
    std::string svg = "<polyline class=\"curve " + name + "\" points=\"";
    for (const MeanPoint& point : series.points) svg += place(x, y, point.seconds, point.error.mean);
    svg += "\"><title>" + escaped(series.name) + "</title></polyline>";
    for (const MeanPoint& point : series.points) {
        const std::string spread = interval(point.error, short_number);
        svg += "<circle class=\"point " + name + "\" cx=\"" + fixed(x.at(point.seconds)) + "\" cy=\"" +
               fixed(y.at(point.error.mean)) + "\" r=\"3\"><title>" +
               escaped(series.name + ": " + short_number(point.error.mean) + " after " + short_seconds(point.seconds) +
                       (spread.empty() ? "" : " (95 %: " + spread + ")")) +
               "</title></circle>";
    }
    return svg;
}

}  // namespace

std::string log_log_plot(const Plot& plot) {
    Range seconds, errors;
    for (const PlotSeries& series : plot.series)
        for (const MeanPoint& point : series.points) {
            seconds.add(point.seconds);
            errors.add(point.error.mean);
        }
    if (errors.high == 0) return "";
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

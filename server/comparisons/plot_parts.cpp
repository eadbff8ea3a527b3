#include "server/comparisons/plot_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/comparisons/levels.h"
#include "server/comparisons/report_text.h"

namespace photond::plot {

namespace {

constexpr size_t kMostLabels = 10;
constexpr double kLogarithmicMargin = 1.12;  // factor beyond the data on each side
constexpr double kLinearMargin = 0.06;       // of what is seen

/// 1, 2 or 5 times a power of ten: so many steps at most from low to high.
double round_step(double low, double high, size_t steps) {
    return round_level_above((high - low) / static_cast<double>(steps));
}

}  // namespace

double Axis::at(double value) const {
    const double share = logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return from + (to - from) * share;
}

double Axis::at_within(double value) const { return at(std::clamp(value, low, high)); }

std::vector<double> Axis::ticks() const {
    if (logarithmic) return round_levels(low, high);
    std::vector<double> ticks;
    const double step = round_step(low, high, kMostLabels);
    for (double k = std::ceil(low / step); k * step <= high; ++k) ticks.push_back(k * step + 0.0);  // no "-0"
    return ticks;
}

std::vector<double> Axis::labelled_ticks() const {
    std::vector<double> all = ticks();
    if (!logarithmic || all.size() <= kMostLabels) return all;
    std::vector<double> decades;  // 1, 10, 100 ...
    for (const double tick : all)
        if (const double exponent = std::log10(tick); std::abs(exponent - std::round(exponent)) < 1e-9)
            decades.push_back(tick);
    return decades;
}

void Range::add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
}

Axis Range::logarithmic_axis(double from, double to) const {
    return {low / kLogarithmicMargin, high * kLogarithmicMargin, from, to, true};
}

Axis Range::linear_axis(double from, double to) const {
    const double margin = high > low ? kLinearMargin * (high - low) : 0.5;
    return {low - margin, high + margin, from, to, false};
}

std::string fixed(double value) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.2f", value);
    return text.data();
}

std::string text_at(double x, double y, const char* anchor, const std::string& text, const char* more) {
    return "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
           escaped(text) + "</text>";
}

std::string line(const std::string& kind, double x0, double y0, double x1, double y1) {
    return "<line class=\"" + kind + "\" x1=\"" + fixed(x0) + "\" y1=\"" + fixed(y0) + "\" x2=\"" + fixed(x1) +
           "\" y2=\"" + fixed(y1) + "\"/>";
}

std::string begin(const std::string& title) {
    return "<svg class=\"plot\" viewBox=\"0 0 " + fixed(kWidth) + " " + fixed(kHeight) +
           "\" role=\"img\" aria-label=\"" + escaped(title) + "\">";
}

std::string axes(const Axis& x, const Axis& y, const std::string& x_name, const std::string& y_name) {
    std::string svg;
    for (const double tick : x.ticks()) svg += line("grid", x.at(tick), y.from, x.at(tick), y.to);
    for (const double tick : y.ticks()) svg += line("grid", x.from, y.at(tick), x.to, y.at(tick));
    for (const double tick : x.labelled_ticks()) svg += text_at(x.at(tick), y.from + 18, "middle", short_number(tick));
    for (const double tick : y.labelled_ticks()) svg += text_at(x.from - 8, y.at(tick) + 4, "end", short_number(tick));
    svg += line("axis", x.from, y.from, x.to, y.from) + line("axis", x.from, y.from, x.from, y.to);
    svg += text_at((x.from + x.to) / 2, kHeight - 8, "middle", x_name);
    const double middle = (y.from + y.to) / 2;
    return svg + text_at(16, middle, "middle", y_name, (" transform=\"rotate(-90 16 " + fixed(middle) + ")\"").c_str());
}

std::string point(const Axis& x, const Axis& y, double across, double up) {
    return fixed(x.at(across)) + "," + fixed(y.at_within(up)) + " ";
}

std::string dot(const std::string& kind, double x, double y, const std::string& title) {
    return "<circle class=\"point " + kind + "\" cx=\"" + fixed(x) + "\" cy=\"" + fixed(y) + "\" r=\"3\"><title>" +
           escaped(title) + "</title></circle>";
}

std::string upper_bound(const std::string& kind, double x, double y, const std::string& title) {
    return "<path class=\"bound " + kind + "\" d=\"M" + fixed(x - 5) + " " + fixed(y) +
           "h10m-5 0v15m-4 -5l4 5l4 -5\"><title>" + escaped(title) + "</title></path>";
}

std::string curve(const std::string& kind, const std::string& points, const std::string& title) {
    if (points.empty()) return "";
    return "<polyline class=\"curve " + kind + "\" points=\"" + points + "\"><title>" + escaped(title) +
           "</title></polyline>";
}

}  // namespace photond::plot

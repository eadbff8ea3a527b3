#pragma once
// What plots are made of: axes, and marks as SVG. Lengths are in units of the view box, colours come from the page.

#include <limits>
#include <string>
#include <vector>

namespace photond::plot {

/// The view box, and the frame that the data lie in.
inline constexpr double kWidth = 860, kHeight = 440;
inline constexpr double kLeft = 78, kRight = 14, kTop = 12, kBottom = 50;

/// One axis: from values in [low, high] to places in the view box.
struct Axis {
    double low, high, from, to;
    bool logarithmic = true;  // both ends are positive then

    double at(double value) const;
    /// Of a value that may lie outside: then that of the nearer end.
    double at_within(double value) const;
    /// Round values: some for lines, at most ten of them for texts.
    std::vector<double> ticks() const;
    std::vector<double> labelled_ticks() const;
};

/// What an axis has to hold.
struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

    void add(double value);
    bool empty() const { return !(low <= high); }
    /// With some room beyond both ends.
    Axis logarithmic_axis(double from, double to) const;
    Axis linear_axis(double from, double to) const;
};

/// A logarithmic axis goes down to this share of the upper end of what is known of a value: a value near 0 by luck is
/// not to draw the axis down.
inline constexpr double kSeenBelow = 0.1;

/// Two digits after the point.
std::string fixed(double value);
std::string text_at(double x, double y, const char* anchor, const std::string& text, const char* more = "");
std::string line(const std::string& kind, double x0, double y0, double x1, double y1);
/// The beginning of the SVG; "</svg>" ends it.
std::string begin(const std::string& title);
/// Grid, labels and both axes with their names.
std::string axes(const Axis& x, const Axis& y, const std::string& x_name, const std::string& y_name);
/// "x,y " of a point in a list.
std::string point(const Axis& x, const Axis& y, double across, double up);

/// A value with a text to hover on.
std::string dot(const std::string& kind, double x, double y, const std::string& title);
/// An arrow down: no more than this.
std::string upper_bound(const std::string& kind, double x, double y, const std::string& title);
/// A line through points as point() writes them; empty where there is none.
std::string curve(const std::string& kind, const std::string& points, const std::string& title);

}  // namespace photond::plot

#include "renderer/error/color_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/srgb.h"
#include "renderer/error/white_relative_xyz.h"

namespace photond {

namespace {

using Color = std::array<double, 3>;

/// Cylindrical CIELAB: lightness 0 to 100, chroma, hue [degrees]: about 320 purple, 40 red, 65 orange, 100 yellow.
struct Lch {
    double lightness, chroma, hue;
};

Color linear_rgb(const Lch& c) {
    const double hue = c.hue * (3.14159265358979323846 / 180);
    const double fy = (c.lightness + 16) / 116;
    const double f[3] = {fy + c.chroma * std::cos(hue) / 500, fy, fy - c.chroma * std::sin(hue) / 200};
    constexpr double kDelta = 6.0 / 29;
    Color rgb{};
    for (size_t j = 0; j < 3; ++j) {
        const double xyz = f[j] > kDelta ? f[j] * f[j] * f[j] : 3 * kDelta * kDelta * (f[j] - 4.0 / 29);
        for (size_t i = 0; i < 3; ++i) rgb[i] += kRgbFromXyz[i][j] * xyz;
    }
    return rgb;
}

bool displayable(const Color& rgb) {
    return std::all_of(rgb.begin(), rgb.end(), [](double value) { return value >= 0 && value <= 1; });
}

/// The colour, or with less chroma if no display shows it: lightness and hue stay.
Color nearest_displayable(Lch c) {
    if (const Color rgb = linear_rgb(c); displayable(rgb)) return rgb;
    double inside = 0, outside = c.chroma;
    for (int step = 0; step < 30; ++step) {
        c.chroma = 0.5 * (inside + outside);
        (displayable(linear_rgb(c)) ? inside : outside) = c.chroma;
    }
    c.chroma = inside;
    return linear_rgb(c);
}

/// Cubic curve through values at even steps over [0, 1] (Catmull and Rom; level beyond the ends).
template <size_t N>
double curve_through(const std::array<double, N>& values, double t) {
    const double place = t * (N - 1);
    const auto i = std::min(static_cast<size_t>(place), N - 2);
    const double u = place - static_cast<double>(i);
    const double p0 = values[i > 0 ? i - 1 : 0], p1 = values[i], p2 = values[i + 1],
                 p3 = values[std::min(i + 2, N - 1)];
    return p1 + 0.5 * u * (p2 - p0 + u * (2 * p0 - 5 * p1 + 4 * p2 - p3 + u * (3 * (p1 - p2) + p3 - p0)));
}

/// Lightness is linear. Hue turns from blue-purple over red and orange to yellow, faster at first, when there is little
/// chroma to see it by. Chroma stays inside what displays can show along this path (52 at a fifth of it, 87 in the
/// middle), so that no primary shows as a crease.
Lch map_color(double t) {
    constexpr double kDarkest = 2, kBrightest = 98;
    constexpr std::array<double, 9> kChroma{0, 36, 49, 59, 74, 78, 66, 46, 12};
    return {kDarkest + (kBrightest - kDarkest) * t, curve_through(kChroma, t), 285 + 178 * std::pow(t, 0.8)};
}

using Entry = std::array<uint8_t, 3>;
constexpr Entry kMidGrey{119, 119, 119};  // L* 50

std::array<Entry, 256> make_table() {
    std::array<Entry, 256> table{};
    for (size_t i = 0; i < table.size(); ++i) {
        const Color rgb = nearest_displayable(map_color(static_cast<double>(i) / 255));
        for (size_t k = 0; k < 3; ++k) {
            const float encoded = srgb_encode(static_cast<float>(std::clamp(rgb[k], 0.0, 1.0)));
            table[i][k] = static_cast<uint8_t>(std::lround(255 * encoded));
        }
    }
    return table;
}

/// 99th percentile of the finite magnitudes above 0; 1 where there is none.
float brightest(std::span<const float> values) {
    std::vector<float> magnitudes;
    for (const float value : values)
        if (const float magnitude = std::fabs(value); std::isfinite(magnitude) && magnitude > 0)
            magnitudes.push_back(magnitude);
    if (magnitudes.empty()) return 1;
    const auto place =
        magnitudes.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(magnitudes.size() - 1));
    std::nth_element(magnitudes.begin(), place, magnitudes.end());
    return *place;
}

}  // namespace

std::vector<uint8_t> color_mapped(std::span<const float> values) {
    static const std::array<Entry, 256> table = make_table();
    std::vector<uint8_t> rgb;
    rgb.reserve(3 * values.size());
    for (const float value : values) {
        const auto index = [value] { return static_cast<size_t>(std::lround(255 * std::clamp(value, 0.0f, 1.0f))); };
        const Entry& entry = std::isnan(value) ? kMidGrey : table[index()];
        rgb.insert(rgb.end(), entry.begin(), entry.end());
    }
    return rgb;
}

std::vector<uint8_t> scaled_color_map(std::span<const float> values) {
    std::vector<float> shares(values.begin(), values.end());
    const float greatest = brightest(values);
    for (float& share : shares) share /= greatest;
    return color_mapped(shares);
}

std::vector<uint8_t> signed_color_map(std::span<const float> values) {
    std::vector<uint8_t> rgb;
    rgb.reserve(3 * values.size());
    const float greatest = brightest(values);
    for (const float value : values) {
        if (std::isnan(value)) {
            rgb.insert(rgb.end(), kMidGrey.begin(), kMidGrey.end());
            continue;
        }
        const float share = std::clamp(value / greatest, -1.0f, 1.0f);
        const auto faded = static_cast<uint8_t>(std::lround(255 * (1 - std::fabs(share))));
        const Entry entry = share < 0 ? Entry{faded, faded, 255} : Entry{255, faded, faded};
        rgb.insert(rgb.end(), entry.begin(), entry.end());
    }
    return rgb;
}

std::vector<uint8_t> overlap_heat_map(std::span<const float> splats) {
    constexpr float kStep = 200;  // splats from each of these to the next
    constexpr std::array<std::array<float, 3>, 4> kColors{{{0, 0, 255}, {0, 255, 0}, {255, 0, 0}, {255, 255, 255}}};
    std::vector<uint8_t> rgb;
    rgb.reserve(3 * splats.size());
    for (const float count : splats) {
        if (std::isnan(count)) {
            rgb.insert(rgb.end(), kMidGrey.begin(), kMidGrey.end());
            continue;
        }
        const float place = std::clamp(count / kStep, 0.0f, static_cast<float>(kColors.size() - 1));
        const size_t below = std::min(static_cast<size_t>(place), kColors.size() - 2);
        const float share = place - static_cast<float>(below);
        for (size_t k = 0; k < 3; ++k) {
            const float value = (1 - share) * kColors[below][k] + share * kColors[below + 1][k];
            rgb.push_back(static_cast<uint8_t>(std::lround(value)));
        }
    }
    return rgb;
}

}  // namespace photond

#include "renderer/error/flip_exposures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/rgb.h"
#include "renderer/error/aces_tone_curve.h"

namespace photond {

namespace {

constexpr double kDisplayedValue = 0.85;  // t

float shown(float value) { return value > 0 && std::isfinite(value) ? value : 0.0f; }

std::vector<float> luminances_of(std::span<const float> rgb) {
    std::vector<float> luminances(rgb.size() / 3);
    for (size_t i = 0; i < luminances.size(); ++i) {
        const float y = luminance({shown(rgb[3 * i]), shown(rgb[3 * i + 1]), shown(rgb[3 * i + 2])});
        luminances[i] = y < std::numeric_limits<float>::min() ? 0.0f : y;
    }
    return luminances;
}

/// Of at least one value, which are reordered.
double median_of(std::vector<float>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 == 1) return *middle;
    return 0.5 * (double{*middle} + double{*std::max_element(values.begin(), middle)});
}

}  // namespace

std::vector<float> flip_exposures(std::span<const float> reference) {
    std::vector<float> luminances = luminances_of(reference);
    const double largest = luminances.empty() ? 0 : *std::max_element(luminances.begin(), luminances.end());
    if (largest == 0) return {0.0f};
    double median = median_of(luminances);
    if (median == 0) {
        std::erase(luminances, 0.0f);
        median = median_of(luminances);
    }
    const double start = std::log2(AcesToneCurve::inverse(kDisplayedValue) / largest);
    const double stops = std::log2(largest / median);  // from start to stop
    if (stops == 0) return {static_cast<float>(start)};
    const double count = std::max(2.0, std::ceil(stops));
    std::vector<float> exposures;
    for (double i = 0; i < count; ++i) exposures.push_back(static_cast<float>(start + i * stops / (count - 1)));
    return exposures;
}

}  // namespace photond

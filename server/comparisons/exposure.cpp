#include "server/comparisons/exposure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

namespace photond {

double exposure_stops(const std::filesystem::path& raw) {
    constexpr double kKey = 0.18, kSteps = 4, kMost = 16;  // steps a stop; most stops
    std::ifstream in(raw, std::ios::binary);
    std::array<float, 3 * 4096> pixels{};
    double sum = 0, count = 0;
    while (in) {
        in.read(reinterpret_cast<char*>(pixels.data()), sizeof(pixels));
        const size_t values = static_cast<size_t>(in.gcount()) / sizeof(float);
        for (size_t i = 0; i + 2 < values; i += 3) {
            const double luminance = 0.2126 * pixels[i] + 0.7152 * pixels[i + 1] + 0.0722 * pixels[i + 2];  // Rec.709
            if (!(luminance > 0) || !std::isfinite(luminance)) continue;
            sum += std::log2(luminance);
            ++count;
        }
    }
    if (count == 0) return 0;
    const double stops = std::log2(kKey) - sum / count;
    return std::clamp(std::round(stops * kSteps) / kSteps, -kMost, kMost);
}

}  // namespace photond

#include "renderer/film/tone_curve.h"

#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/core/srgb.h"

namespace photond {

namespace {

/// Fit to the ACES reference and output transforms, with the exposure the fit leaves out (times 0.6): middle grey,
/// 0.18, comes out as 0.14. [Narkowicz 2016] ACES Filmic Tone Mapping Curve.
float filmic(float x) {
    x *= 0.6f;
    if (x > 1e4f) return 1.0f;  // the ratio's limit is 2.51/2.43; avoids infinity / infinity
    return (x * (2.51f * x + 0.03f)) / (x * (2.43f * x + 0.59f) + 0.14f);
}

uint8_t encode_channel(float linear, ToneCurve curve) {
    if (!(linear > 0)) return 0;
    const float curved = curve == ToneCurve::Filmic ? filmic(linear) : linear;
    return static_cast<uint8_t>(std::lround(255.0f * srgb_encode(std::min(curved, 1.0f))));
}

}  // namespace

std::optional<ToneCurve> tone_curve_named(std::string_view name) {
    for (size_t i = 0; i < kToneCurveNames.size(); ++i)
        if (kToneCurveNames[i] == name) return static_cast<ToneCurve>(i);
    return std::nullopt;
}

std::vector<uint8_t> tone_mapped(std::span<const float> rgb, float exposure_stops, ToneCurve curve) {
    const float scale = std::exp2(exposure_stops);
    std::vector<uint8_t> encoded(rgb.size());
    parallel_for(rgb.size() / 3, 4096, [&](size_t pixel) {
        const float* in = &rgb[3 * pixel];
        uint8_t* out = &encoded[3 * pixel];
        if (std::isnan(in[0]) || std::isnan(in[1]) || std::isnan(in[2])) {
            out[0] = 255, out[1] = 0, out[2] = 255;
            return;
        }
        for (int k = 0; k < 3; ++k) out[k] = encode_channel(in[k] * scale, curve);
    });
    return encoded;
}

float auto_exposure_stops(std::span<const float> rgb) {
    constexpr float kDarkest = 1e-6f, kMiddleGrey = 0.18f;
    double log_sum = 0;
    size_t lit = 0;
    for (size_t i = 0; i + 2 < rgb.size(); i += 3) {
        const float value = luminance({rgb[i], rgb[i + 1], rgb[i + 2]});
        if (!(value > kDarkest) || !std::isfinite(value)) continue;
        log_sum += std::log2(double{value});
        ++lit;
    }
    if (lit == 0) return 0;
    return static_cast<float>(std::log2(double{kMiddleGrey}) - log_sum / static_cast<double>(lit));
}

}  // namespace photond

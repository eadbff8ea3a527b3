#pragma once
// From scene-linear radiance to the 8-bit values of a preview.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/core/rgb.h"

namespace photond {

enum class ToneCurve : uint8_t {
    Srgb,    // clipped at 1
    Filmic,  // rolls highlights off instead of clipping them
};
inline constexpr std::array<std::string_view, 2> kToneCurveNames{"srgb", "filmic"};
std::optional<ToneCurve> tone_curve_named(std::string_view name);

/// 8-bit sRGB of interleaved RGB radiance after scaling by 2^exposure_stops. A pixel that holds a NaN is magenta;
/// infinity is full white in its channel, negative values are 0.
std::vector<uint8_t> tone_mapped(std::span<const float> rgb, float exposure_stops, ToneCurve curve);

/// Exposure [stops] that brings the log-average luminance of the lit pixels (above 1e-6) to middle grey (0.18);
/// 0 when none is lit. [Reinhard et al. 2002] Photographic Tone Reproduction for Digital Images, Eq. 1.
float auto_exposure_stops(std::span<const float> rgb);

}  // namespace photond

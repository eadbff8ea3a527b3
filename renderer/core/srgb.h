#pragma once
// The sRGB curve of IEC 61966-2-1, between scene-linear values and what a display is sent, both in [0, 1].

#include <cmath>

namespace photond {

/// Linear values up to this one are encoded by a straight line, above it by a power.
inline constexpr float kSrgbLinearEnd = 0.0031308f;

inline float srgb_encode(float linear) {
    return linear <= kSrgbLinearEnd ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

inline double srgb_decode(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace photond

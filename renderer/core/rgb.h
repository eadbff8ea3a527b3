#pragma once
// Scene-linear colour with Rec.709 primaries. The same type serves radiance [W m^-2 sr^-1], flux [W], irradiance
// [W m^-2] and reflectance; the variable's name says which.

#include <algorithm>

#include "renderer/core/geometry.h"

namespace photond {

using Rgb = vec3;

/// Relative luminance of Rec.709 primaries.
inline constexpr Rgb kLuminanceWeights{0.2126f, 0.7152f, 0.0722f};
inline float luminance(const Rgb& c) {
    return kLuminanceWeights.x * c.x + kLuminanceWeights.y * c.y + kLuminanceWeights.z * c.z;
}
inline float max_component(const Rgb& c) { return std::max({c.x, c.y, c.z}); }
inline float mean(const Rgb& c) { return (c.x + c.y + c.z) / 3.0f; }
inline bool is_black(const Rgb& c) { return c.x == 0.0f && c.y == 0.0f && c.z == 0.0f; }
inline bool is_finite(const Rgb& c) { return std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z); }

}  // namespace photond

#pragma once
// How values are shown as colours: error and FLIP maps from [0, 1] by a map whose lightness rises evenly, dark to
// bright; counts of splats by the colours of the photon-splatting thesis.

#include <cstdint>
#include <span>
#include <vector>

namespace photond {

/// 8-bit sRGB, interleaved, of values clamped to [0, 1]; a NaN is shown as mid-grey.
std::vector<uint8_t> color_mapped(std::span<const float> values);

/// 8-bit sRGB, interleaved, of how many splats lie over a pixel: blue 0, green 200, red 400, white 600 and more, linear
/// in between in display values; below 0 as 0, a NaN mid-grey. [Hoet 2014, Figure 18]
std::vector<uint8_t> overlap_heat_map(std::span<const float> splats);

/// color_mapped() of values over the 99th percentile of those that are finite and above 0: dark at 0.
std::vector<uint8_t> scaled_color_map(std::span<const float> values);

/// 8-bit sRGB, interleaved: blue below 0, white at 0, red above it, linear in display values up to the 99th percentile
/// of the finite magnitudes above 0; a NaN is shown as mid-grey.
std::vector<uint8_t> signed_color_map(std::span<const float> values);

}  // namespace photond

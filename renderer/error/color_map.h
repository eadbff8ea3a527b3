#pragma once
// How error and FLIP maps are shown: a map from [0, 1] to colours whose lightness rises evenly, dark to bright.

#include <cstdint>
#include <span>
#include <vector>

namespace photond {

/// 8-bit sRGB, interleaved, of values clamped to [0, 1]; a NaN is shown as mid-grey.
std::vector<uint8_t> color_mapped(std::span<const float> values);

}  // namespace photond

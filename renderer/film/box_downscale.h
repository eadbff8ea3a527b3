#pragma once
// Smaller images of an image, in linear light.

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// The size of an image scaled down so that its longer side is `max_side`, the shorter one rounded and at least 1; its
/// own size where that is not larger.
Size2 size_within(Size2 size, uint32_t max_side);

/// Each new pixel is the mean of the old ones below it, by the areas that they share: constants stay what they are, and
/// so does the mean of the whole. `values` are interleaved, row 0 at the top; `to` is at most `from` in both
/// directions.
std::vector<float> box_downscaled(std::span<const float> values, uint32_t channels, Size2 from, Size2 to);

}  // namespace photond

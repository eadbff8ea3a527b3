#pragma once
// A Welch map to look at.

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

struct BlockMark {
    double difference = 0;  // as WelchBlock's
    bool found = false;
};

/// 8-bit sRGB of an image of `pixels`, in blocks of `block` a side (row by row, one mark each; asserted): grey where
/// there is no difference, red where the method is brighter and blue where it is darker, full from
/// kGreatestMappedBias on and by its root below. Blocks that are found have a black frame; what chance explains is
/// pale.
std::vector<uint8_t> welch_picture(Size2 pixels, uint32_t block, std::span<const BlockMark> marks);

inline constexpr double kGreatestMappedBias = 0.1;

}  // namespace photond

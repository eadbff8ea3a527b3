#include "renderer/error/welch_picture.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace photond {

namespace {

using Color = std::array<double, 3>;

// sRGB. Red and blue are as light as each other, and told apart by who confuses red with green.
constexpr Color kNone{236, 236, 236}, kBrighter{190, 42, 32}, kDarker{32, 82, 178};
constexpr double kByChance = 0.35;  // of the colour that a difference has where chance explains it

Color color_of(const BlockMark& mark) {
    const double size = std::sqrt(std::min(std::fabs(mark.difference) / kGreatestMappedBias, 1.0));
    const double share = std::isfinite(size) ? (mark.found ? size : kByChance * size) : 0;
    const Color& full = mark.difference > 0 ? kBrighter : kDarker;
    Color color{};
    for (size_t c = 0; c < 3; ++c) color[c] = kNone[c] + share * (full[c] - kNone[c]);
    return color;
}

}  // namespace

std::vector<uint8_t> welch_picture(Size2 pixels, uint32_t block, std::span<const BlockMark> marks) {
    assert(block > 0);
    const uint32_t columns = (pixels.width + block - 1) / block, frame = std::max(1u, block / 16);
    assert(marks.size() == size_t{columns} * ((pixels.height + block - 1) / block));
    std::vector<uint8_t> rgb;
    rgb.reserve(3 * pixels.pixels());
    for (uint32_t y = 0; y < pixels.height; ++y)
        for (uint32_t x = 0; x < pixels.width; ++x) {
            const BlockMark& mark = marks[size_t{y / block} * columns + x / block];
            // Blocks at the right and at the bottom may be cut.
            const auto at_edge = [&](uint32_t at, uint32_t size) {
                const uint32_t first = at / block * block, last = std::min(first + block, size) - 1;
                return at - first < frame || last - at < frame;
            };
            const bool framed = mark.found && (at_edge(x, pixels.width) || at_edge(y, pixels.height));
            const Color color = framed ? Color{} : color_of(mark);
            for (const double channel : color) rgb.push_back(static_cast<uint8_t>(std::lround(channel)));
        }
    return rgb;
}

}  // namespace photond

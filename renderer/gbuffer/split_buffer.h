#pragma once
// The split G-buffer: pixels that share a subset of the lights lie together. The image is cut into blocks of n x n
// pixels; the pixels at one place of their blocks make one of n^2 tiles [Sun 2015, 4.6, equations 4.1 to 4.6: n = 4].
// GLSL twin: split_buffer.glsl.
//
// [Keller and Heidrich 2001] Interleaved Sampling. EGWR. [Segovia et al. 2006] Non-interleaved Deferred Shading of
// Interleaved Sample Patterns. Graphics Hardware.

#include <cstdint>

#include "renderer/core/geometry.h"

namespace photond {

/// Where pixels of an image are in its split buffer, an array of padded tiles, row after row in each.
struct SplitLayout {
    /// Tiles are padded to a multiple of that many points, so that no group of threads sees two of them.
    static constexpr uint32_t kGroup = 64;

    SplitLayout() = default;
    /// `side`: n, 1 to 8.
    SplitLayout(Size2 image_size, uint32_t n)
        : size(image_size),
          side(n),
          tile_width((image_size.width + n - 1) / n),
          tile_height((image_size.height + n - 1) / n),
          tile_points((tile_width * tile_height + kGroup - 1) / kGroup * kGroup) {}

    uint32_t tiles() const { return side * side; }
    uint32_t points() const { return tiles() * tile_points; }

    uint32_t tile_of(uint32_t point) const { return point / tile_points; }
    /// The place of a pixel in the split buffer.
    uint32_t point_of(uint32_t x, uint32_t y) const {
        return (y % side * side + x % side) * tile_points + y / side * tile_width + x / side;
    }
    static constexpr uint32_t kNoPixel = ~0u;
    /// The pixel at a place, counted row by row in the image; kNoPixel for padding.
    uint32_t pixel_of(uint32_t point) const {
        const uint32_t tile = tile_of(point), place = point % tile_points;
        const uint32_t x = place % tile_width * side + tile % side, y = place / tile_width * side + tile / side;
        return place < tile_width * tile_height && x < size.width && y < size.height ? y * size.width + x : kNoPixel;
    }

    /// The place shown at a pixel where the buffer is looked at as it lies: tile beside tile, cut to the image where
    /// tiles overhang it.
    uint32_t point_shown_at(uint32_t x, uint32_t y) const {
        const uint32_t tile = y / tile_height * side + x / tile_width;
        return tile * tile_points + y % tile_height * tile_width + x % tile_width;
    }

    Size2 size{};
    uint32_t side = 1, tile_width = 0, tile_height = 0, tile_points = 0;
};

}  // namespace photond

#pragma once
// Which connections and merging a pixel has. Blocks of pixels may differ, for what is worth its cost at a caustic's
// edge is not worth it on the wall beside; light paths are the whole image's. All techniques of a pixel are weighed by
// its own numbers, whichever pixels a light path may be seen by.

#include <utility>
#include <vector>

#include "renderer/bidirectional/mis_weights.h"
#include "renderer/core/geometry.h"
#include "renderer/core/rgb.h"

namespace photond {

struct BlockTechniques {
    uint32_t connections_per_vertex = 0;  // of an eye vertex, with vertices drawn from the cache
    TechniqueNumbers numbers;

    bool operator==(const BlockTechniques&) const = default;
};

/// Layer `techniques`, as layers.h says.
inline Rgb shown_techniques(const BlockTechniques& techniques, Size2 image) {
    const float light_paths = techniques.numbers.light_paths / static_cast<float>(image.pixels());
    return {techniques.numbers.merges ? 1.0f : 0.0f, static_cast<float>(techniques.connections_per_vertex) / 8,
            light_paths / 2};
}

/// A grid of blocks over an image, the last of a row and column being cut off by its border.
class TechniqueBlocks {
public:
    static constexpr uint32_t kOfAll = ~0u;  // no block: a number for what is the same in each

    /// `side`: of a block [pixels]; `blocks`: row by row.
    TechniqueBlocks(Size2 image, uint32_t side, std::vector<BlockTechniques> blocks)
        : side_(side), columns_(columns_of(image, side)), blocks_(std::move(blocks)) {}

    static uint32_t columns_of(Size2 image, uint32_t side) { return (image.width + side - 1) / side; }
    static Size2 count_of(Size2 image, uint32_t side) {
        return {columns_of(image, side), (image.height + side - 1) / side};
    }

    uint32_t index_at(uint32_t x, uint32_t y) const { return y / side_ * columns_ + x / side_; }
    const BlockTechniques& operator[](uint32_t block) const { return blocks_[block]; }
    uint64_t bytes() const { return blocks_.capacity() * sizeof(BlockTechniques); }

private:
    uint32_t side_, columns_;
    std::vector<BlockTechniques> blocks_;
};

}  // namespace photond

#include "renderer/voxels/svo_cells.h"

#include <algorithm>
#include <bit>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr uint32_t kMostBits = 6;  // 3 MiB, which second-level caches hold most of
constexpr uint8_t kFarthest = 255;

uint32_t bits_of(uint32_t resolution) {
    return std::min(static_cast<uint32_t>(std::countr_zero(resolution / BRICK_SIDE)), kMostBits);
}

/// Largest free cubes of one octant: a cell's is by one larger than the least of its seven neighbours'. What is beyond
/// the grid is free.
void measure_octant(const SvoCells& cells, uint32_t octant, uint8_t* free) {
    const int n = 1 << cells.bits;
    const auto row = static_cast<size_t>(n) + 1;
    // Of this z and the one before: rows of y from the farthest, each with the border.
    std::vector<uint8_t> before(row * row, kFarthest), now(row * row, kFarthest);
    std::vector<uint8_t> least(row);
    for (int k = n; k-- > 0;) {
        const auto z = static_cast<size_t>(octant & 4 ? n - 1 - k : k);
        for (int j = n; j-- > 0;) {
            const auto y = static_cast<size_t>(octant & 2 ? n - 1 - j : j);
            const size_t first = (z << cells.bits | y) << cells.bits;
            uint8_t* const own = now.data() + static_cast<size_t>(j) * row;
            const uint8_t* const beside = own + row;
            const uint8_t* const below = before.data() + static_cast<size_t>(j) * row;
            // All but the one along the row, which the one before waits for.
            for (size_t i = 0; i + 1 < row; ++i)
                least[i] = std::min({beside[i], beside[i + 1], below[i], below[i + 1], below[i + row],
                                     below[i + row + 1], static_cast<uint8_t>(kFarthest - 1)});
            uint8_t ahead = kFarthest;
            for (int i = n; i-- > 0;) {
                const size_t at = first + static_cast<size_t>(octant & 1 ? n - 1 - i : i);
                ahead = cells.starts[at] != SVO_NO_DATA
                            ? uint8_t{0}
                            : static_cast<uint8_t>(std::min(ahead, least[static_cast<size_t>(i)]) + 1);
                own[i] = free[at] = ahead;
            }
        }
        std::swap(before, now);
    }
}

}  // namespace

SvoCells::SvoCells(const gpu::SvoConstants& constants, std::span<const gpu::SvoNode> nodes)
    : bits(bits_of(constants.grid.resolution)),
      shift(static_cast<uint32_t>(std::countr_zero(constants.grid.resolution)) - bits),
      starts(plane(), SVO_NO_DATA),
      free(8 * plane() + 1, 1) {
    const uint32_t reach = ((1u << shift) - 1) * (1 | 1 << 10 | 1 << 20);
    for (const gpu::SvoNode& node : nodes) {
        if (!(node.info & SVO_FLAGGED) || node.high - node.low != reach) continue;
        const uint32_t x = node.low & 1023, y = node.low >> 10 & 1023, z = node.low >> 20;
        starts[(x | y << bits | z << 2 * bits) >> shift] = node.info & SVO_LEAF ? node.data : node.info & SVO_TILE_MASK;
    }
    parallel_for(8, 1, [&](size_t octant) {
        measure_octant(*this, static_cast<uint32_t>(octant), free.data() + octant * plane());
    });
}

size_t SvoCells::estimate_bytes(uint32_t resolution) { return size_t{12} << 3 * bits_of(resolution); }

}  // namespace photond

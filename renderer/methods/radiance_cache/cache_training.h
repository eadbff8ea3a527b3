#pragma once
// The paths that fill a cache: how many, of which tiles of the image, and the grid that they fill.

#include <cstdint>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/methods/radiance_cache/cell_grid.h"
#include "renderer/methods/radiance_cache/params.h"

namespace photond {

/// The passes that a cache serves: as many as it is filled by.
struct CacheBlock {
    uint32_t first = 0;
    uint32_t passes = 1;
};
/// The block that a pass lies in: of 1, 2, 4, 8 passes, and of 16 from then on.
CacheBlock cache_block_of(uint32_t pass);

/// Tiles of the paths that fill the cache. They come in rounds, so that their samples take little room; with
/// SecondBounces::Cache those from the second on end in what those before have left.
struct CacheTraining {
    static constexpr uint32_t kTileSide = 8;     // pixels
    static constexpr uint32_t kLeastRounds = 4;  // of a pass's share

    /// `most_tiles`: of a round.
    CacheTraining(Size2 size, float paths_a_pixel, uint32_t most_tiles);
    uint64_t all() const { return uint64_t{columns} * rows; }
    uint64_t tiles_of_round() const { return (tiles + rounds - 1) / rounds; }
    /// All tiles of the image in an order of their own; the first `tiles` are those of that draw.
    std::vector<uint32_t> order(uint32_t draw, uint32_t key) const;

    uint32_t columns, rows;
    uint32_t times;          // that tiles are drawn for a pass, with numbers of their own
    uint64_t tiles, rounds;  // of each
};

/// Of the block's random numbers.
uint32_t cache_key(uint64_t seed, const CacheBlock& block);
/// The grid of a block: its cells shrink from block to block, and its origin is drawn.
CellGrid cache_grid(const Bounds3& bounds, const vec3& eye, uint64_t seed, const RadianceCacheParams& params,
                    const CacheBlock& block);
/// Why no path asks a cache; null: they do.
const char* why_no_cache(const RadianceCacheParams& params, bool lights);

}  // namespace photond

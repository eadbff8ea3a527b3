#include "renderer/methods/radiance_cache/cache_training.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "renderer/core/rng.h"

namespace photond {

CacheBlock cache_block_of(uint32_t pass) {
    constexpr uint32_t kMost = 16, kDoubling = kMost - 1;
    if (pass >= kDoubling) return {pass - (pass - kDoubling) % kMost, kMost};
    const uint32_t passes = std::bit_floor(pass + 1);
    return {passes - 1, passes};
}

CacheTraining::CacheTraining(Size2 size, float paths_a_pixel, uint32_t most_tiles)
    : columns((size.width + kTileSide - 1) / kTileSide), rows((size.height + kTileSide - 1) / kTileSide) {
    times = std::max(static_cast<uint32_t>(std::ceil(paths_a_pixel)), 1u);
    const double wanted = std::ceil(double{paths_a_pixel} / times * static_cast<double>(all()));
    tiles = static_cast<uint64_t>(std::max(wanted, 1.0));
    rounds = std::max<uint64_t>(kLeastRounds, (tiles + most_tiles - 1) / most_tiles);
}

std::vector<uint32_t> CacheTraining::order(uint32_t draw, uint32_t key) const {
    std::vector<std::pair<uint32_t, uint32_t>> sorted(all());  // a number to sort by, then the tile
    for (uint32_t tile = 0; tile < sorted.size(); ++tile) sorted[tile] = {hash32(tile ^ hash32(draw ^ key)), tile};
    std::sort(sorted.begin(), sorted.end());
    std::vector<uint32_t> order(sorted.size());
    for (size_t i = 0; i < sorted.size(); ++i) order[i] = sorted[i].second;
    return order;
}

uint32_t cache_key(uint64_t seed, const CacheBlock& block) { return static_cast<uint32_t>(hash64(seed) + block.first); }

CellGrid cache_grid(const Bounds3& bounds, const vec3& eye, uint64_t seed, const RadianceCacheParams& params,
                    const CacheBlock& block) {
    RandomStream stream(seed, RandomDomain::CacheTraining, block.first, 0);
    CellGrid grid;
    grid.eye = eye;
    grid.coarsest_m = 2 * std::max(bounds.radius(), 1e-20f);
    grid.of_distance = params.cell_size * params.share_of_pass(block.first);
    grid.origin = eye;
    for (int axis = 0; axis < 3; ++axis) grid.origin[axis] += grid.coarsest_m * stream.next();
    return grid;
}

const char* why_no_cache(const RadianceCacheParams& params, bool lights) {
    if (params.max_scatterings() < 2) return "no bounce was asked for";
    return lights ? nullptr : "the scene has no light";
}

}  // namespace photond

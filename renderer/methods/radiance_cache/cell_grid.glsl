// GLSL twin of cell_grid.h. Define CACHE_CONSTANTS_BINDING (of set 0) before.
#ifndef PHOTOND_CELL_GRID_GLSL
#define PHOTOND_CELL_GRID_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/methods/radiance_cache/radiance_cache_shared.h"

layout(set = 0, binding = CACHE_CONSTANTS_BINDING, scalar) readonly buffer CacheConstantsBuffer { CacheConstants cache; };

struct CellKey {
    uint place;
    uint fingerprint;
};

float cell_side_m(uint level) { return cache.coarsest_m / float(1u << level); }

uint cell_level_of(float side) {
    return uint(clamp(ceil(log2(cache.coarsest_m / side)), 0.0, float(CACHE_MOST_LEVEL)));
}

/// CellGrid::level(). False: there is none.
bool cell_level(float distance_m, float spread_m, out uint level) {
    level = cell_level_of(cache.of_distance * distance_m);
    if (spread_m >= cell_side_m(level)) return true;
    const uint by_eye = level;
    level = cell_level_of(spread_m);
    return level <= by_eye + CACHE_FINER_LEVELS && spread_m >= cell_side_m(level);
}

uint cell_word(float x) { return uint(int(x)); }

CellKey cell_key(vec3 position, vec3 normal, uint direction, uint level) {
    const vec3 cell = floor((position - cache.origin) / cell_side_m(level));
    const vec3 side = floor(2.0 * normal + 0.5) + 2.0;
    const uint facing = cell_word(side.x) + 5u * (cell_word(side.y) + 5u * cell_word(side.z));
    const uint parts[3] = {cell_word(cell.y), cell_word(cell.z), level | facing << 5 | direction << 12};
    uint place = hash32(cell_word(cell.x) ^ 0x9e3779b9u), fingerprint = hash32(cell_word(cell.x) ^ 0x7f4a7c15u);
    for (int i = 0; i < 3; ++i) {
        place = hash32(place ^ parts[i]);
        fingerprint = hash32(fingerprint + parts[i]);
    }
    return CellKey(place, max(fingerprint, 1u));
}

uint direction_bin(vec3 direction, uint side) {
    const vec3 n = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    vec2 on_square = n.xy;
    if (n.z < 0.0) on_square = vec2(copysign(1.0 - abs(n.y), n.x), copysign(1.0 - abs(n.x), n.y));
    const float most = float(side);
    const uvec2 row = uvec2(clamp(floor(0.5 * (on_square + 1.0) * most), 0.0, most - 1.0));
    return row.x + side * row.y;
}

/// Levels that a sample of a finest one belongs to as well, and that are asked after it: as many as this.
uint coarser_levels(uint finest, float spread_m) {
    uint count = 0u;
    while (count < CACHE_COARSER_LEVELS && count < finest && cell_side_m(finest - count - 1u) <= spread_m) ++count;
    return count;
}

#endif

#pragma once
// Places along a Morton curve: points that are near in space are mostly near on it.

#include "renderer/core/geometry.h"

namespace photond {

inline constexpr uint32_t kMortonBits = 10;  // an axis

/// The lowest ten bits of x, two zeros between each.
constexpr uint32_t spread_bits(uint32_t x) {
    x &= 0x3ffu;
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/// Of a cell of a grid of 2^10 cells a side; x changes fastest.
constexpr uint32_t morton_code(const uvec3& cell) {
    return spread_bits(cell.x) | spread_bits(cell.y) << 1 | spread_bits(cell.z) << 2;
}

/// The lowest 16 bits of x, two zeros between each.
constexpr uint64_t spread_bits_wide(uint64_t x) {
    x &= 0xffffu;
    x = (x | x << 16) & 0x001f'0000'ff00'00ffull;
    x = (x | x << 8) & 0x100f'00f0'0f00'f00full;
    x = (x | x << 4) & 0x10c3'0c30'c30c'30c3ull;
    return (x | x << 2) & 0x1249'2492'4924'9249ull;
}

/// Of a cell of a grid of up to 2^16 cells a side.
constexpr uint64_t morton_code_wide(const uvec3& cell) {
    return spread_bits_wide(cell.x) | spread_bits_wide(cell.y) << 1 | spread_bits_wide(cell.z) << 2;
}

/// Of a point within the bounds; points outside count as on the border.
inline uint32_t morton_code(const Bounds3& bounds, const vec3& p) {
    constexpr float kLast = static_cast<float>((1u << kMortonBits) - 1);
    const vec3 extent = glm::max(bounds.diagonal(), vec3(1e-30f));
    return morton_code(uvec3(glm::clamp((p - bounds.min) / extent, 0.0f, 1.0f) * kLast));
}

}  // namespace photond

#pragma once
// Places along a Hilbert curve through the unit square: neighbours on it are neighbours in the square, and equal parts
// of it have equal areas.
//
// [Hilbert 1891] Über die stetige Abbildung einer Linie auf ein Flächenstück. Mathematische Annalen 38.

#include "renderer/core/geometry.h"

namespace photond {

/// A square of the curve's construction on the way down: in which order the curve passes its four quadrants.
/// GLSL twin: hilbert.glsl.
struct HilbertSquare {
    uint32_t swapped = 0;  // x and y change places ...
    uint32_t flipped = 0;  // ... then both run backwards

    /// The quadrant passed `child`-th (0 to 3): its column and row (0 or 1).
    uvec2 quadrant(uint32_t child) const {
        const uint32_t x = child >> 1, y = (child ^ child >> 1) & 1u;
        return uvec2(swapped ? y : x, swapped ? x : y) ^ uvec2(flipped);
    }
    /// The other way.
    uint32_t child(const uvec2& quadrant) const {
        const uvec2 q = quadrant ^ uvec2(flipped);
        const uint32_t x = swapped ? q.y : q.x, y = swapped ? q.x : q.y;
        return 2 * x + (x ^ y);
    }
    HilbertSquare below(uint32_t child) const {
        return {swapped ^ uint32_t{child == 0 || child == 3}, flipped ^ uint32_t{child == 3}};
    }
};

inline constexpr uint32_t kHilbertLevels = 22;  // of the two below: 44 bits along the curve, 22 an axis

/// The cell of 2^22 a side that comes `place`-th.
inline uvec2 hilbert_cell(uint64_t place) {
    HilbertSquare square;
    uvec2 cell(0);
    for (int level = static_cast<int>(kHilbertLevels) - 1; level >= 0; --level) {
        const auto child = static_cast<uint32_t>(place >> 2 * level & 3u);
        cell = 2u * cell + square.quadrant(child);
        square = square.below(child);
    }
    return cell;
}

/// When that cell comes.
inline uint64_t hilbert_place(const uvec2& cell) {
    HilbertSquare square;
    uint64_t place = 0;
    for (int level = static_cast<int>(kHilbertLevels) - 1; level >= 0; --level) {
        const uint32_t child = square.child((cell >> static_cast<uint32_t>(level)) & uvec2(1));
        place = place << 2 | child;
        square = square.below(child);
    }
    return place;
}

}  // namespace photond

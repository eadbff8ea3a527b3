// GLSL twin of core/hilbert.h: places along a Hilbert curve through the unit square.
#ifndef PHOTOND_HILBERT_GLSL
#define PHOTOND_HILBERT_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

/// A square of the curve's construction on the way down: in which order the curve passes its four quadrants.
struct HilbertSquare {
    bool swapped;   // x and y change places ...
    uint flipped;  // ... then both run backwards
};
HilbertSquare hilbert_whole() { return HilbertSquare(false, 0u); }

/// The quadrant passed `child`-th (0 to 3): its column and row (0 or 1).
uvec2 hilbert_quadrant(HilbertSquare square, uint child) {
    const uvec2 q = uvec2(child >> 1, (child ^ child >> 1) & 1u);
    return (square.swapped ? q.yx : q) ^ uvec2(square.flipped);
}
/// The other way.
uint hilbert_child(HilbertSquare square, uvec2 quadrant) {
    const uvec2 flipped = quadrant ^ uvec2(square.flipped);
    const uvec2 q = square.swapped ? flipped.yx : flipped;
    return 2u * q.x + (q.x ^ q.y);
}
HilbertSquare hilbert_below(HilbertSquare square, uint child) {
    return HilbertSquare(square.swapped != (child == 0u || child == 3u), square.flipped ^ uint(child == 3u));
}

const int HILBERT_LEVELS = 22;  // kHilbertLevels

/// The cell of 2^22 a side that comes `place`-th.
uvec2 hilbert_cell(uint64_t place) {
    HilbertSquare square = hilbert_whole();
    uvec2 cell = uvec2(0);
    for (int level = HILBERT_LEVELS - 1; level >= 0; --level) {
        const uint child = uint(place >> (2 * level)) & 3u;
        cell = 2u * cell + hilbert_quadrant(square, child);
        square = hilbert_below(square, child);
    }
    return cell;
}

/// When that cell comes.
uint64_t hilbert_place(uvec2 cell) {
    HilbertSquare square = hilbert_whole();
    uint64_t place = 0ul;
    for (int level = HILBERT_LEVELS - 1; level >= 0; --level) {
        const uint child = hilbert_child(square, (cell >> level) & 1u);
        place = place << 2 | uint64_t(child);
        square = hilbert_below(square, child);
    }
    return place;
}

#endif

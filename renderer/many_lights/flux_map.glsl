// GLSL twin of many_lights/flux_map.h: choice among texels by a pyramid of sums, with the same whole numbers.
//
// Define FLUX_SUMS_BINDING (of set 0) before to choose: the texels' worth, then the sums, level above level.
#ifndef PHOTOND_FLUX_MAP_GLSL
#define PHOTOND_FLUX_MAP_GLSL

#include "renderer/core/hilbert.glsl"
#include "renderer/many_lights/flux_map_shared.h"

/// Where the sums of so many squares start: behind 4^levels texels and the levels between.
uint flux_level(uint levels, uint squares) { return ((4u << (2u * levels)) - 4u * squares) / 3u; }

/// Point i of the Halton sequence in bases 2 and 3, rotated, in fractions of 2^32.
uvec2 rotated_halton_point(uint i, uvec2 rotation) {
    uint in_base_3 = 0, left = i;
    for (uint digit = 0; digit < 20; ++digit, left /= 3) in_base_3 = 3u * in_base_3 + left % 3u;
    return uvec2(bitfieldReverse(i), uint((uint64_t(in_base_3) << 32) / 3486784401ul)) + rotation;
}

#ifdef FLUX_SUMS_BINDING

layout(set = 0, binding = FLUX_SUMS_BINDING, scalar) readonly buffer FluxSums { float flux_sums[]; };

struct Texel {
    uint index;         // along the curve
    float probability;  // with which a uniform point chooses it
};

float flux_total(uint levels) { return flux_sums[flux_level(levels, 1u)]; }

/// Divides a number, in fractions of 2^32, between two by their weights and stretches what the chosen one has to the
/// whole again. The probability is multiplied by the share that was really used. True: the second.
bool flux_divide(float first, float second, inout uint u, inout float probability) {
    if (!(second > 0.0)) return false;
    if (!(first > 0.0)) return true;
    const uint share = uint(clamp(first / (first + second) * 4294967296.0, 1.0, 4294967040.0));
    const bool is_second = u >= share;
    const uint mine = is_second ? 0u - share : share;
    u = uint((uint64_t(is_second ? u - share : u) << 32) / uint64_t(mine));
    probability *= float(mine) * 2.3283064365386963e-10;  // 2^-32
    return is_second;
}

/// By a point of the unit square, in fractions of 2^32; not where the total is 0.
Texel flux_choose(uint levels, uvec2 point) {
    Texel texel = Texel(0u, 1.0);
    HilbertSquare square = hilbert_whole();
    for (uint level = 1; level <= levels; ++level) {
        const uint first = flux_level(levels, 1u << (2u * level)) + 4u * texel.index;
        float worth[4];  // by quadrant
        for (uint q = 0; q < 4; ++q) worth[q] = flux_sums[first + hilbert_child(square, uvec2(q & 1u, q >> 1))];
        const bool second_row = flux_divide(worth[0] + worth[1], worth[2] + worth[3], point.y, texel.probability);
        const bool second_column = flux_divide(second_row ? worth[2] : worth[0], second_row ? worth[3] : worth[1],
                                               point.x, texel.probability);
        const uint child = hilbert_child(square, uvec2(uint(second_column), uint(second_row)));
        texel.index = 4u * texel.index + child;
        square = hilbert_below(square, child);
    }
    return texel;
}

#endif

#endif

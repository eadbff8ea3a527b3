// GLSL twin of stratification.cpp: the codes of photons' cells, and runs of photons that are sorted by them.
// Define PHOTONS_BINDING, ORDER_BINDING, KEYS_BINDING and PLACES_BINDING first.
#ifndef PHOTOND_STRATIFICATION_GLSL
#define PHOTOND_STRATIFICATION_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/methods/photon_splatting/stratification_shared.h"
#include "renderer/photons/reflected_photon_shared.h"

layout(constant_id = STRATIFICATION_WIDE_ID) const bool WIDE = false;

layout(push_constant, scalar) uniform Push { StratificationConstants push; };
layout(set = 0, binding = PHOTONS_BINDING, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = ORDER_BINDING, scalar) readonly buffer Order { uint order[]; };

/// The lowest 16 bits of x, two zeros between each.
uint64_t spread_bits_wide(uint64_t x) {
    x &= 0xfffful;
    x = (x | x << 16) & 0x001f0000ff0000fful;
    x = (x | x << 8) & 0x100f00f00f00f00ful;
    x = (x | x << 4) & 0x10c30c30c30c30c3ul;
    return (x | x << 2) & 0x1249249249249249ul;
}

/// Greater than all codes of cells.
uint64_t outside() { return (1ul << 3 * push.levels) - 1; }
/// Of photons that have none: greater than all.
uint64_t no_power() { return 1ul << 3 * push.levels; }

/// The code of a photon's cell.
uint64_t cell_code(ReflectedPhotonRecord photon) {
    if (is_black(photon.power_w)) return no_power();
    const vec3 p = photon.position;
    // Written so that NaN is outside, as everything is where the bounds are empty.
    const bool inside = all(greaterThanEqual(p, push.low)) && all(lessThanEqual(p, push.high));
    if (!inside) return outside();
    const uvec3 cell = uvec3(max(vec3(0.0), fma(p - push.grid_min, vec3(push.cells_per_m), push.first)));
    return spread_bits_wide(cell.x) | spread_bits_wide(cell.y) << 1 | spread_bits_wide(cell.z) << 2;
}

#ifdef KEYS_BINDING
layout(set = 0, binding = KEYS_BINDING, scalar) readonly buffer Keys { uint keys[]; };      // sorted
layout(set = 0, binding = PLACES_BINDING, scalar) readonly buffer Places { uint places[]; };  // in the order of photons

/// The k-th photon in the order of the codes.
ReflectedPhotonRecord sorted_photon(uint k) { return photons[order[places[k]]]; }
uint64_t sorted_code(uint k) { return WIDE ? cell_code(sorted_photon(k)) : uint64_t(keys[k]); }

/// The last code of the block of that level that a code of a cell is in; never that of photons outside.
uint64_t last_code(uint64_t code, uint level) { return min(code | ((1ul << 3 * level) - 1), outside() - 1); }

/// The end of the block of that level about the k-th photon, which is inside: doubling steps, as most blocks are small.
uint block_end(uint k, uint64_t code, uint level) {
    const uint64_t last = last_code(code, level);
    uint step = 1;
    while (step < push.photons - k && sorted_code(k + step) <= last) step *= 2;
    uint low = k + step / 2 + 1, high = min(step < push.photons - k ? k + step : push.photons, push.photons);
    while (low < high) {
        const uint middle = low + (high - low) / 2;
        if (sorted_code(middle) <= last)
            low = middle + 1;
        else
            high = middle;
    }
    return high;
}

/// The beginning of that block, found in the same way.
uint block_begin(uint k, uint64_t code, uint level) {
    const uint64_t first = code >> 3 * level << 3 * level;
    uint step = 1;
    while (step <= k && sorted_code(k - step) >= first) step *= 2;
    uint low = step <= k ? k - step + 1 : 0, high = k - step / 2;
    while (low < high) {
        const uint middle = low + (high - low) / 2;
        if (sorted_code(middle) >= first)
            high = middle;
        else
            low = middle + 1;
    }
    return high;
}
#endif

#endif

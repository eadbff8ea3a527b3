// Puts every tile's keys and values where their digits go, in order within a digit.
//
// A warp takes its share of the tile row by row of WARP keys. The keys of a row that have a digit find each other by
// the bits they set in one word; those before in the row, in the warp's rows before, in the warps before and in the
// tiles before give a key its place. The tile is first brought into order in shared memory, so that neighbouring
// threads write neighbouring words.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define DEVICE_TILES_BINDING 0
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/backends/gpu/group_sum.glsl"
#include "renderer/backends/gpu/radix_sort_shared.h"

layout(push_constant, scalar) uniform Push { RadixSortConstants push; };
layout(set = 0, binding = 1, scalar) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Starts { uint starts[]; };  // among its digit's, [digit * tiles + tile]
layout(set = 0, binding = 4, scalar) readonly buffer Totals { uint totals[]; };  // of a digit
layout(set = 0, binding = 5, scalar) writeonly buffer SortedKeys { uint sorted_keys[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer SortedValues { uint sorted_values[]; };

const uint MASKS = 0, FOUND = WARPS * RADIX_MOST_DIGITS;  // of each warp's digits: [warp * digits + digit]
shared uint words[2 * WARPS * RADIX_MOST_DIGITS];         // then the tile's keys in order, then its values
shared uint tile_starts[RADIX_MOST_DIGITS];               // where a digit begins in the ordered tile
shared uint sorted_starts[RADIX_MOST_DIGITS];             // the same element's place in all

uint digit_of(uint key) { return (key >> push.shift) & (push.digits - 1); }

void main() {
    const uint tile = tile_index();
    if (tile >= tiles_state.tiles) return;
    const uint thread = group_thread(), warp = thread / WARP, lane = thread % WARP;
    const uint digits = push.digits, first = tile * TILE, count = min(tiles_state.elements - first, TILE);

    for (uint i = thread; i < WARPS * digits; i += GROUP) words[MASKS + i] = words[FOUND + i] = 0;
    barrier();

    // Places among the warp's own keys of a digit.
    uint key[TILE_ITEMS], place[TILE_ITEMS];
    const uint warp_first = warp * (WARP * TILE_ITEMS) + lane;
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = warp_first + k * WARP;
        key[k] = i < count ? keys[first + i] : 0;
    }
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const bool valid = warp_first + k * WARP < count;
        const uint slot = warp * digits + digit_of(key[k]);
        if (valid) atomicOr(words[MASKS + slot], 1u << lane);
        warp_barrier();
        const uint same = words[MASKS + slot];
        place[k] = words[FOUND + slot] + bitCount(same & ((1u << lane) - 1));
        warp_barrier();
        if (valid && findMSB(same) == int(lane)) {  // one of them counts for all
            words[FOUND + slot] = place[k] + 1;
            words[MASKS + slot] = 0;
        }
        warp_barrier();
    }
    barrier();

    // Sums over warps, then over digits, of this tile and of all.
    const uint digits_each = (digits + GROUP - 1) / GROUP, digit_first = thread * digits_each;
    uint in_tile = 0, in_all = 0;
    for (uint digit = digit_first; digit < min(digit_first + digits_each, digits); ++digit) {
        uint before = 0;
        for (uint w = 0; w < WARPS; ++w) {
            const uint found = words[FOUND + w * digits + digit];
            words[FOUND + w * digits + digit] = before;
            before += found;
        }
        const uint total = totals[digit];
        tile_starts[digit] = before, sorted_starts[digit] = total;
        in_tile += before, in_all += total;
    }
    uint unused;
    uint tile_start = group_exclusive_sum(in_tile, unused), all_start = group_exclusive_sum(in_all, unused);
    for (uint digit = digit_first; digit < min(digit_first + digits_each, digits); ++digit) {
        const uint tile_total = tile_starts[digit], total = sorted_starts[digit];
        tile_starts[digit] = tile_start;
        sorted_starts[digit] = all_start + starts[digit * tiles_state.tiles + tile];
        tile_start += tile_total, all_start += total;
    }
    barrier();
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint digit = digit_of(key[k]);
        place[k] += words[FOUND + warp * digits + digit] + tile_starts[digit];
    }
    barrier();

    for (uint k = 0; k < TILE_ITEMS; ++k)
        if (warp_first + k * WARP < count) words[place[k]] = key[k];
    barrier();
    uint target[TILE_ITEMS];
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = k * GROUP + thread;
        if (i >= count) continue;
        const uint sorted_key = words[i], digit = digit_of(sorted_key);
        target[k] = sorted_starts[digit] + (i - tile_starts[digit]);
        sorted_keys[target[k]] = sorted_key;
    }
    barrier();
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = warp_first + k * WARP;
        if (i < count) words[place[k]] = values[first + i];
    }
    barrier();
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = k * GROUP + thread;
        if (i < count) sorted_values[target[k]] = words[i];
    }
}

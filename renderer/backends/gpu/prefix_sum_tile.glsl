// Exclusive sums within a tile of TILE elements, in order.
#ifndef PHOTOND_PREFIX_SUM_TILE_GLSL
#define PHOTOND_PREFIX_SUM_TILE_GLSL

#include "renderer/backends/gpu/group_sum.glsl"

// A thread's elements are neighbours; one word more after each thread's keeps threads off each other's banks.
shared uint tile_words[MOST_GROUP_THREADS * (TILE_ITEMS + 1)];

/// Where element `i` of the tile is kept.
uint tile_word(uint i) { return i + i / TILE_ITEMS; }

/// Puts in place of every element of tile_words[tile_word(0 .. TILE - 1)] the sum of those before it, plus `start`;
/// gives the sum of all. Elements are to be written before, by any thread, and are there for any thread after.
uint tile_exclusive_sum(uint start) {
    barrier();
    const uint first = group_thread() * (TILE_ITEMS + 1);
    uint sum = 0;
    for (uint k = 0; k < TILE_ITEMS; ++k) sum += tile_words[first + k];
    uint total;
    uint before = start + group_exclusive_sum(sum, total);
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint x = tile_words[first + k];
        tile_words[first + k] = before;
        before += x;
    }
    barrier();
    return total;
}

#endif

// Exclusive sums of every tile's elements, from what comes before the tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define DEVICE_TILES_BINDING 0
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/backends/gpu/prefix_sum_tile.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Words { uint words[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Starts { uint tile_starts[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Sums { uint sums[]; };  // may be the buffer of words

void main() {
    const uint tile = tile_index();
    if (tile >= tiles_state.tiles) return;
    const uint thread = group_thread(), first = tile * TILE, elements = tiles_state.elements;
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = k * GROUP + thread;
        tile_words[tile_word(i)] = first + i < elements ? words[first + i] : 0;
    }
    tile_exclusive_sum(tile_starts[tile]);
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = k * GROUP + thread;
        if (first + i < elements) sums[first + i] = tile_words[tile_word(i)];
    }
}

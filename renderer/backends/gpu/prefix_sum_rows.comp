// Exclusive sums of rows of words, one group a row; a row has a word a tile, and starts where the one before ends.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define DEVICE_TILES_BINDING 0
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/backends/gpu/prefix_sum_tile.glsl"

layout(push_constant, scalar) uniform Push { uint total_index; } push;
layout(set = 0, binding = 1, scalar) buffer Rows { uint rows[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Totals { uint totals[]; };  // of row r: [total_index + r]

void main() {
    const uint thread = group_thread(), row = gl_WorkGroupID.x, length = tiles_state.tiles, start = row * length;
    uint sum = 0;
    for (uint first = 0; first < length; first += TILE) {
        for (uint k = 0; k < TILE_ITEMS; ++k) {
            const uint i = k * GROUP + thread;
            tile_words[tile_word(i)] = first + i < length ? rows[start + first + i] : 0;
        }
        sum += tile_exclusive_sum(sum);
        for (uint k = 0; k < TILE_ITEMS; ++k) {
            const uint i = k * GROUP + thread;
            if (first + i < length) rows[start + first + i] = tile_words[tile_word(i)];
        }
        barrier();  // read, before the next are written
    }
    if (thread == 0) totals[push.total_index + row] = sum;
}

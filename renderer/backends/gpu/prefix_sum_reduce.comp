// The sum of every tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define DEVICE_TILES_BINDING 0
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/backends/gpu/group_sum.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Words { uint words[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Sums { uint tile_sums[]; };

void main() {
    const uint tile = tile_index();
    if (tile >= tiles_state.tiles) return;
    const uint thread = group_thread(), first = tile * TILE;
    uint sum = 0;
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = first + k * GROUP + thread;
        if (i < tiles_state.elements) sum += words[i];
    }
    uint total;
    group_exclusive_sum(sum, total);
    if (thread == 0) tile_sums[tile] = total;
}

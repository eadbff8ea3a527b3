// How often every digit comes in every tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define DEVICE_TILES_BINDING 0
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/backends/gpu/group_sum.glsl"
#include "renderer/backends/gpu/radix_sort_shared.h"

layout(push_constant, scalar) uniform Push { RadixSortConstants push; };
layout(set = 0, binding = 1, scalar) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Counts { uint counts[]; };  // [digit * tiles + tile]

shared uint found[RADIX_MOST_DIGITS];

void main() {
    const uint tile = tile_index();
    if (tile >= tiles_state.tiles) return;
    const uint thread = group_thread(), first = tile * TILE;
    for (uint digit = thread; digit < push.digits; digit += GROUP) found[digit] = 0;
    barrier();
    for (uint k = 0; k < TILE_ITEMS; ++k) {
        const uint i = first + k * GROUP + thread;
        if (i < tiles_state.elements) atomicAdd(found[(keys[i] >> push.shift) & (push.digits - 1)], 1);
    }
    barrier();
    for (uint digit = thread; digit < push.digits; digit += GROUP)
        counts[digit * tiles_state.tiles + tile] = found[digit];
}

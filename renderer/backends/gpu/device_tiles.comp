// Turns a count on the device into the size of an indirect dispatch.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/backends/gpu/device_tiles_shared.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { DeviceTilesConstants push; };
layout(set = 0, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 1, scalar) buffer State { DeviceTilesState state; };

void main() {
    const uint elements = min(counts[push.count_index], push.capacity);
    const uint tiles = elements / push.tile + (elements % push.tile > 0 ? 1 : 0);
    state.elements = elements;
    state.tiles = tiles;
    state.groups[0] = min(tiles, push.row_groups);
    state.groups[1] = (tiles + push.row_groups - 1) / push.row_groups;
    state.groups[2] = 1;
}

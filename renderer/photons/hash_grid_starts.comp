#version 460
// Where each slot's points begin, of keys in their order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/hash_grid_shared.h"

layout(local_size_x = HASH_GRID_GROUP) in;
layout(push_constant, scalar) uniform Push { HashGridConstants grid; };
layout(set = 0, binding = 0, scalar) readonly buffer Count { uint count[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Starts { uint starts[]; };

void main() {
    const uint slot = flat_index();
    if (slot > grid.slots) return;
    uint low = 0, high = min(count[0], grid.capacity);  // the first key at or beyond the slot is in [low, high]
    while (low < high) {
        const uint middle = (low + high) / 2;
        if (keys[middle] < slot) low = middle + 1; else high = middle;
    }
    starts[grid.first_start + slot] = low;
}

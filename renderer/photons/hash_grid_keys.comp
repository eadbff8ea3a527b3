#version 460
// The slot of each photon in the grid's table, in the order they have now.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/hash_grid.glsl"

layout(local_size_x = HASH_GRID_GROUP) in;
layout(push_constant, scalar) uniform Push { HashGridConstants grid; };
layout(set = 0, binding = 0, scalar) readonly buffer Count { uint count[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 2, std430) readonly buffer Places { uvec4 places[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Keys { uint keys[]; };

void main() {
    const uint i = flat_index();
    if (i >= min(count[0], grid.capacity)) return;
    keys[i] = grid_slot_of(grid, uintBitsToFloat(places[order[i]].xyz));
}

#version 460
// Places of light paths' vertices into the order of their grid.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/hash_grid_shared.h"

layout(local_size_x = HASH_GRID_GROUP) in;
layout(push_constant, scalar) uniform Push { HashGridConstants grid; };
layout(set = 0, binding = 0, scalar) readonly buffer Count { uint count[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 2, std430) readonly buffer Places { uvec4 places[]; };
layout(set = 0, binding = 3, std430) writeonly buffer GridPlaces { uvec4 grid_places[]; };

void main() {
    const uint i = flat_index();
    if (i < min(count[0], grid.capacity)) grid_places[grid.first_point + i] = places[order[i]];
}

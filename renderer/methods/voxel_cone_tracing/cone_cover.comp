#version 460
// How much of each voxel its surfaces cover, seen along each axis: of a square of rays through it, those that meet
// something. A group has a brick, a thread a voxel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define CONE_CELLS_ACCESS writeonly
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_cells.glsl"

layout(local_size_x = CONE_GROUP) in;
layout(push_constant, scalar) uniform Push { ConeCoverPush push; };
layout(set = 0, binding = 6, scalar) readonly buffer Places { uvec3 brick_places[]; };

float cover(vec3 low, float cell_m, int axis) {
    vec3 along = vec3(0.0), across = vec3(0.0), up = vec3(0.0);
    along[axis] = 1.0, across[(axis + 1) % 3] = 1.0, up[(axis + 2) % 3] = 1.0;
    uint met = 0u;
    for (uint i = 0u; i < COVER_RAYS_SIDE * COVER_RAYS_SIDE; ++i) {
        const vec2 at = (vec2(i % COVER_RAYS_SIDE, i / COVER_RAYS_SIDE) + 0.5) / float(COVER_RAYS_SIDE);
        const vec3 origin = low + cell_m * (at.x * across + at.y * up - VOXEL_SHIFT * along);
        if (occluded(Ray(origin, along, cell_m))) ++met;
    }
    return float(met) / float(COVER_RAYS_SIDE * COVER_RAYS_SIDE);
}

void main() {
    const uint brick = push.first + flat_index() / CONE_GROUP;
    if (brick >= push.end || brick_places[brick].x == NO_CONE_CELL) return;  // there is room for more than there are
    const uint bit = gl_LocalInvocationIndex;
    const ivec3 voxel = ivec3(bit & 3u, bit >> 2u & 3u, bit >> 4u) + ivec3(4u * brick_places[brick]);
    const uint cell = voxel_in_brick(brick, voxel);
    if (cell == NO_CONE_CELL) return;
    const float cell_m = svo_constants.grid.cell_m;
    const vec3 low = svo_constants.grid.low + cell_m * vec3(voxel);
    cone_cells[cell].opacity = pack_opacity(vec3(cover(low, cell_m, 0), cover(low, cell_m, 1), cover(low, cell_m, 2)));
}

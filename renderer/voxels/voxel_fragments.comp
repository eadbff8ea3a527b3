#version 460
// One column of bricks of one triangle a thread: a fragment for each brick of it that has a voxel touched.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require

#define DEVICE_TILES_BINDING 0
#define SVO_FIRST_TRIANGLES_BINDING 2
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/voxels/svo_build_shared.h"
#include "renderer/voxels/svo_triangles.glsl"
#include "renderer/voxels/triangle_voxels.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { SvoConstants constants; };
layout(set = 0, binding = 3, scalar) readonly buffer Columns { uint first_columns[]; };  // each triangle's
layout(set = 0, binding = 4, scalar) buffer State { uint state[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Fragments { SvoFragment fragments[]; };

/// The last triangle that begins at or before a column: those without any begin where the next one does.
uint triangle_of(uint column) {
    uint low = 0u, high = constants.triangle_count;
    while (high - low > 1u) {
        const uint middle = (low + high) / 2u;
        if (first_columns[middle] <= column) low = middle; else high = middle;
    }
    return low;
}

void main() {
    const uint column = tile_index() * SVO_GROUP + gl_LocalInvocationIndex;
    if (column >= tiles_state.elements) return;
    const uint number = triangle_of(column);
    const uvec2 place = svo_triangle(number, constants.instance_count);
    const TriangleVoxels triangle = make_triangle_voxels(quantised_triangle(constants, place.x, place.y),
                                                         int(constants.grid.resolution) / BRICK_SIDE);
    ivec3 turned;
    const ivec2 range = triangle_column(triangle, column - first_columns[number], turned);
    for (int along = range.x; along < range.y; ++along) {
        const ivec3 brick = axis_back(ivec3(turned.xy, along), triangle.axis);
        const uvec2 mask = triangle_brick_mask(triangle, brick);
        if (mask == uvec2(0u)) continue;
        const uvec4 here = subgroupBallot(true);
        uint first = 0u;
        if (subgroupElect()) first = atomicAdd(state[SVO_STATE_FRAGMENTS], subgroupBallotBitCount(here));
        const uint at = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(here);
        if (at < push.fragment_capacity)
            fragments[at] = SvoFragment(uint(brick.x) | uint(brick.y) << 8 | uint(brick.z) << 16, number,
                                        uint[2](mask.x, mask.y));
    }
}

#version 460
// One column of bricks of one triangle a thread: a fragment for each brick of it that has a voxel touched, which flags
// the brick and the nodes above it (thesis, 4.3.2, step 5).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require

#define SVO_ASKED_BINDING 2
#include "renderer/voxels/svo_asked.glsl"
#include "renderer/voxels/svo_build.glsl"
#include "renderer/voxels/triangle_voxels.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { SvoConstants constants; };
layout(set = 0, binding = 3, scalar) readonly buffer Columns { uint columns[]; };
layout(set = 0, binding = 4, scalar) readonly buffer ColumnStarts { uint column_starts[]; };
layout(set = 0, binding = 5, scalar) buffer Flags { uint flags[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Fragments { SvoFragment fragments[]; };

uint first_column(uint triangle) { return columns[triangle] + column_starts[triangle / push.sum_group]; }

/// The last triangle that begins at or before a column: those without any begin where the next one does.
uint triangle_of(uint column) {
    uint low = 0u, high = push.asked_triangles;
    while (high - low > 1u) {
        const uint middle = (low + high) / 2u;
        if (first_column(middle) <= column) low = middle; else high = middle;
    }
    return low;
}

uint morton_code(uvec3 brick) {
    uint code = 0u;
    for (uint bit = 0u; bit < SVO_MOST_LEVELS; ++bit) {
        const uvec3 at = (brick >> bit) & 1u;
        code |= (at.x | at.y << 1 | at.z << 2) << 3u * bit;
    }
    return code;
}

/// Whoever flags a node flags the one above it too, so that what is found flagged needs nothing more.
void flag(uint code) {
    for (uint level = push.levels; level > 0u; --level, code >>= 3) {
        const uint word = SVO_FIRST_WORD(level) + code / 32u, bit = 1u << code % 32u;
        if ((flags[word] & bit) != 0u || (atomicOr(flags[word], bit) & bit) != 0u) return;
    }
}

void main() {
    const uint column = flat_index();
    if (column >= state.columns) return;
    const uint number = triangle_of(column);
    const SvoAskedInstance place = asked_instance(number, push.asked);
    const uint of_instance = number - place.first;
    const TriangleVoxels triangle = make_triangle_voxels(quantised_triangle(constants, place.instance, of_instance),
                                                         int(constants.grid.resolution) / BRICK_SIDE);
    ivec3 turned;
    const ivec2 range = triangle_column(triangle, column - first_column(number), turned);
    for (int along = range.x; along < range.y; ++along) {
        const ivec3 brick = axis_back(ivec3(turned.xy, along), triangle.axis);
        const uvec2 mask = triangle_brick_mask(triangle, brick);
        if (mask == uvec2(0u)) continue;
        const uvec4 here = subgroupBallot(true);
        uint first = 0u;
        if (subgroupElect()) first = atomicAdd(state.fragments, subgroupBallotBitCount(here));
        const uint at = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(here);
        const uint code = morton_code(uvec3(brick));
        if (at < push.fragment_capacity)
            fragments[at] = SvoFragment(code, place.first_triangle + of_instance, uint[2](mask.x, mask.y));
        flag(code);
    }
}

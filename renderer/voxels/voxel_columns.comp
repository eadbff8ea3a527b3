#version 460
// How many columns of bricks each triangle has.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#include "renderer/backends/gpu/invocation.glsl"
#define SVO_FIRST_TRIANGLES_BINDING 1
#include "renderer/voxels/svo_build_shared.h"
#include "renderer/voxels/svo_triangles.glsl"
#include "renderer/voxels/triangle_voxels.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(set = 0, binding = 0, scalar) readonly buffer Constants { SvoConstants constants; };
layout(set = 0, binding = 2, scalar) buffer State { uint state[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Columns { uint columns[]; };

void main() {
    const uint number = flat_index();
    if (number >= constants.triangle_count) return;
    const uvec2 place = svo_triangle(number, constants.instance_count);
    uint count = 0u;
    if (is_voxelised(place.x)) {
        const QuantisedTriangle triangle = quantised_triangle(constants, place.x, place.y);
        count = triangle_columns(make_triangle_voxels(triangle, int(constants.grid.resolution) / BRICK_SIDE));
    }
    columns[number] = count;

    const uint sum = subgroupAdd(count);
    if (!subgroupElect() || sum == 0u) return;
    const uint before = atomicAdd(state[SVO_STATE_COLUMNS_LOW], sum);
    if (before + sum < before) atomicAdd(state[SVO_STATE_COLUMNS_HIGH], 1u);  // the carry
}

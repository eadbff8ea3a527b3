#version 460
// How many columns of bricks each asked triangle has, as sums. The groups after the triangles' own, where there are any,
// empty what the passes after this one add to.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define SVO_ASKED_BINDING 2
#define SVO_GROUP_STARTS_BINDING 4
#include "renderer/voxels/svo_sums.glsl"
#include "renderer/voxels/svo_asked.glsl"
#include "renderer/voxels/triangle_voxels.glsl"

layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { SvoConstants constants; };
layout(set = 0, binding = 3, scalar) writeonly buffer Columns { uint columns[]; };  // before each triangle, in its group
layout(set = 0, binding = 5, scalar) writeonly buffer Flags { uint flags[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Bricks { uvec2 bricks[]; };
layout(set = 0, binding = 7, scalar) writeonly buffer Surfaces { uint surfaces[]; };

void empty_what_is_added_to(uint thread, uint threads) {
    for (uint i = thread; i < flags.length(); i += threads) flags[i] = i == 0u ? 1u : 0u;  // the root is always there
    for (uint i = thread; i < bricks.length(); i += threads) bricks[i] = uvec2(0u);
    for (uint i = thread; i < surfaces.length(); i += threads) surfaces[i] = SVO_NO_DATA;
}

void main() {
    const uint groups = max(sum_groups(push.asked_triangles), 1u), group = group_number();
    if (group >= groups) {
        empty_what_is_added_to(flat_index() - groups * GROUP,
                               (gl_NumWorkGroups.x * gl_NumWorkGroups.y - groups) * GROUP);
        return;
    }
    const uint number = group * GROUP + group_thread();
    uint count = 0u;
    if (number < push.asked_triangles) {
        const SvoAskedInstance place = asked_instance(number, push.asked);
        if (is_voxelised(place.instance)) {
            const QuantisedTriangle triangle = quantised_triangle(constants, place.instance, number - place.first);
            count = triangle_columns(make_triangle_voxels(triangle, int(constants.grid.resolution) / BRICK_SIDE));
        }
    }
    uint group_columns, all_columns;
    const uint before = group_exclusive_sum(count, group_columns);
    if (number < push.asked_triangles) columns[number] = before;
    if (!end_sums(groups, group_columns, all_columns) || group_thread() != 0u) return;
    state.columns = sums_wrap ? ~0u : all_columns;
    state.column_groups = rows_of_groups(state.columns > SVO_MOST_COLUMNS ? 0u : groups_of(all_columns, SVO_GROUP));
    state.fragments = 0u;
    state.voxels = push.kept_voxels;
}

#version 460
// Cells made of the eight of half their size, a thread a cell: of two in a row along an axis the nearer hides the other.
// [Crassin et al. 2011, section 6]
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define CONE_CELLS_ACCESS
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_cells.glsl"

layout(local_size_x = CONE_GROUP) in;
layout(push_constant, scalar) uniform Push { ConeFilterPush push; };

void main() {
    const int mip = int(push.mip);
    const uint bits = uint(findMSB(svo_constants.grid.resolution)) - push.mip, thread = flat_index();
    if (thread >> 3u * bits != 0u) return;
    const ivec3 place = ivec3(uvec3(thread, thread >> bits, thread >> 2u * bits) & ((1u << bits) - 1u));
    const uint made = cone_cell_at(mip, place);
    if (made == NO_CONE_CELL) return;
    vec3 light[6];
    vec3 opacity = vec3(0.0);
    for (int side = 0; side < 6; ++side) light[side] = vec3(0.0);
    for (int axis = 0; axis < 3; ++axis)
        for (int row = 0; row < 4; ++row) {
            ivec3 low = 2 * place;
            low[(axis + 1) % 3] += row & 1, low[(axis + 2) % 3] += row >> 1;
            ivec3 high = low;
            high[axis] += 1;
            const uint cells[2] = {cone_cell_at(mip - 1, low), cone_cell_at(mip - 1, high)};
            float passed[2] = {1.0, 1.0};
            for (int i = 0; i < 2; ++i)
                if (cells[i] != NO_CONE_CELL) passed[i] = 1.0 - cone_opacity(cone_cells[cells[i]], axis);
            for (int i = 0; i < 2; ++i) {
                if (cells[i] == NO_CONE_CELL) continue;
                // The high one is before the side along the axis.
                const vec3 along = unpack_shared_exponent(cone_cells[cells[i]].light[2 * axis]);
                const vec3 against = unpack_shared_exponent(cone_cells[cells[i]].light[2 * axis + 1]);
                light[2 * axis] += 0.25 * (i == 1 ? 1.0 : passed[1]) * along;
                light[2 * axis + 1] += 0.25 * (i == 0 ? 1.0 : passed[0]) * against;
            }
            opacity[axis] += 0.25 * (1.0 - passed[0] * passed[1]);
        }
    for (int side = 0; side < 6; ++side) cone_cells[made].light[side] = pack_shared_exponent(light[side]);
    cone_cells[made].opacity = pack_opacity(opacity);
}

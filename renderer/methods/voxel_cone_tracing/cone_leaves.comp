#version 460
// The light of photons in their voxels, a thread a voxel, in one order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define CONE_CELLS_ACCESS
#define PHOTON_CELLS_BINDING 6
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/photons_by_cell.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_cells.glsl"

layout(local_size_x = CONE_GROUP) in;

void main() {
    const uint voxel = flat_index();
    if (voxel >= cone_tree.voxels) return;
    vec3 light[6];
    for (int side = 0; side < 6; ++side) light[side] = vec3(0.0);
    for (uint i = first_of_cell(voxel); is_of_cell(i, voxel); ++i) {
        const vec3 normal = photons[values[i]].normal, intensity = INV_PI * photons[values[i]].power_w;
        for (int axis = 0; axis < 3; ++axis) light[2 * axis + (normal[axis] < 0.0 ? 1 : 0)] += abs(normal[axis]) * intensity;
    }
    const float per_m = svo_constants.voxels_per_m;
    for (int side = 0; side < 6; ++side)
        cone_cells[voxel].light[side] = pack_shared_exponent(light[side] * per_m * per_m);
}

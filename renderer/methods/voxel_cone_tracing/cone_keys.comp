#version 460
// Which voxel each photon lights, for the sort by voxels; a thread a photon.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_cells.glsl"
#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = REFLECTION_GROUP) in;
layout(set = 0, binding = 6, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 7, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 8, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 9, scalar) writeonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 10, scalar) writeonly buffer Values { uint values[]; };

/// The voxel it lies in; where no ray found anything in that, of the voxels about it the nearest that has cover, in which
/// the same surface goes on.
uint voxel_of(vec3 position) {
    const vec3 at = (position - svo_constants.grid.low) * svo_constants.voxels_per_m + VOXEL_SHIFT;
    if (!(all(greaterThanEqual(at, vec3(0.0))) && all(lessThan(at, vec3(svo_constants.grid.resolution)))))
        return cone_tree.voxels;
    const ivec3 own = ivec3(at);
    const vec3 within = at - vec3(own);
    uint nearest = cone_tree.voxels;
    float least_sq = INFINITY;
    for (int i = 0; i < 27; ++i) {
        const ivec3 step = (ivec3(i, i / 3, i / 9) + 1) % 3 - 1;  // the photon's own first
        const vec3 off = mix(vec3(0.0), mix(within, 1.0 - within, greaterThan(step, ivec3(0))), notEqual(step, ivec3(0)));
        if (dot(off, off) >= least_sq) continue;
        const uint cell = cone_cell_at(0, own + step);
        if (cell == NO_CONE_CELL || cone_cells[cell].opacity == 0u) continue;
        nearest = cell;
        least_sq = dot(off, off);
        if (i == 0) break;
    }
    return nearest;
}

void main() {
    const uint index = flat_index();
    if (index >= min(state[REFLECTION_PHOTONS], uint(keys.length()))) return;
    const uint photon = order[index];
    keys[index] = voxel_of(photons[photon].position);
    values[index] = photon;
}

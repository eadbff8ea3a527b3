#version 460
// Which cell each photon's light starts in, for the sort by cells: of those about a place half a cell off its surface the
// nearest whose middle lies before the surface and is seen from there. A thread a photon.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PROPAGATION_CASCADES_BINDING 0
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/light_propagation_volumes/propagation.glsl"
#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = REFLECTION_GROUP) in;
layout(push_constant, scalar) uniform Push { InjectionPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Values { uint values[]; };

uint cell_seen(PropagationGrid grid, vec3 position, vec3 normal) {
    const vec3 surface = grid_place(grid, position), place = surface + 0.5 * normal;
    if (!(all(greaterThanEqual(place, vec3(0.0))) && all(lessThan(place, vec3(grid.cells))))) return cascades.cells;
    vec3 between;
    const ivec3 first = cells_about(grid, place, between);
    const vec3 origin = offset_ray_origin(position, normal);
    for (uint asked = 0u; asked != 0xffu;) {
        int best = -1;
        for (int i = 0; i < 8; ++i)
            if ((asked >> i & 1u) == 0u && (best < 0 || weight_about(i, between) > weight_about(best, between))) best = i;
        asked |= 1u << best;
        const ivec3 cell = first + cell_about(best);
        const vec3 to_middle = cell_middle(grid, cell) - origin;
        if (dot(to_middle, normal) > 0.0 && !occluded(Ray(origin, to_middle, 1.0))) return cell_index(grid, cell);
    }
    return cascades.cells;
}

void main() {
    const uint index = flat_index();
    if (index >= min(state[REFLECTION_PHOTONS], uint(keys.length()))) return;
    const uint photon = order[index];
    keys[index] = cell_seen(cascade_grid(push.cascade), photons[photon].position, photons[photon].normal);
    values[index] = photon;
}

#version 460
// The light of photons in their cells, a thread a cell, in one order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PROPAGATION_CASCADES_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/light_propagation_volumes/propagation.glsl"
#define PHOTON_CELLS_BINDING 1
#include "renderer/many_lights/photons_by_cell.glsl"

layout(local_size_x = PROPAGATION_GROUP) in;
layout(push_constant, scalar) uniform Push { InjectionPush push; };
layout(set = 0, binding = 5, scalar) writeonly buffer Injected { CellLight injected[]; };

void main() {
    const uint cell = flat_index();
    if (cell >= cascades.cells) return;
    CellLight light = NO_LIGHT;
    for (uint i = first_of_cell(cell); is_of_cell(i, cell); ++i)
        add_light(light, cosine_lobe(photons[values[i]].power_w, photons[values[i]].normal), 1.0);
    injected[push.cascade * cascades.cells + cell] = light;
}

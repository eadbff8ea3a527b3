#version 460
// The light of photons in their cells, a thread a cell, in one order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PROPAGATION_CASCADES_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/light_propagation_volumes/propagation.glsl"
#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = PROPAGATION_GROUP) in;
layout(push_constant, scalar) uniform Push { InjectionPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Injected { CellLight injected[]; };

void main() {
    const uint cell = flat_index();
    if (cell >= cascades.cells) return;
    const uint photons_of_pass = min(state[REFLECTION_PHOTONS], push.most);
    uint first = 0u, end = photons_of_pass;  // the first of this cell or later ones
    while (first < end) {
        const uint middle = (first + end) / 2u;
        if (keys[middle] < cell) first = middle + 1u; else end = middle;
    }
    CellLight light = NO_LIGHT;
    for (uint i = first; i < photons_of_pass && keys[i] == cell; ++i)
        add_light(light, cosine_lobe(photons[values[i]].power_w, photons[values[i]].normal), 1.0);
    injected[push.cascade * cascades.cells + cell] = light;
}

#version 460
// What choices among the lights take each for, by its path, a thread a light. CPU twin: VplSet::assign().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/path_selection_shared.h"
#include "renderer/many_lights/vpl_set_shared.h"
#include "renderer/many_lights/vpl_tracer_shared.h"
#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = PATH_SELECTION_GROUP) in;
layout(set = 0, binding = 0, scalar) readonly buffer LightCounts { uint counts[VPL_COUNT_WORDS]; };
layout(set = 0, binding = 1, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Owners { PhotonOwner owners[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Places { uint places[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Selected { VplPath selected[]; };
layout(set = 0, binding = 5, scalar) buffer Vpls { Vpl vpls[]; };

void main() {
    const uint light = flat_index();
    if (light < counts[VPL_COUNT]) vpls[light].choice = selected[places[owners[order[light]].path]].choice;
}

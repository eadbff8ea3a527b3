#version 460
// Where the photon is that comes i-th: path after path, and along each by its scatterings.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = REFLECTION_GROUP) in;
#include "renderer/backends/gpu/invocation.glsl"
layout(push_constant, scalar) uniform Push { uint capacity; } push;
layout(set = 0, binding = 0, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 1, scalar) readonly buffer Owners { PhotonOwner owners[]; };
layout(set = 0, binding = 2, scalar) readonly buffer FirstOfPath { uint first_of_path[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Order { uint order[]; };

void main() {
    const uint photon = flat_index();
    // Past the capacity the pass is traced again with more room: orders go wrong then, but never out of bounds.
    if (photon >= min(state[REFLECTION_PHOTONS], push.capacity)) return;
    const uint place = first_of_path[owners[photon].path] + owners[photon].ordinal;
    if (place < push.capacity) order[place] = photon;
}

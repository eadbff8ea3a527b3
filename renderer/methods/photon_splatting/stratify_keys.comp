#version 460
// The code of each photon's cell, in the photons' order or in that of a first sort. A thread a photon.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PHOTONS_BINDING 0
#define ORDER_BINDING 1
#include "renderer/methods/photon_splatting/stratification.glsl"

layout(local_size_x = STRATIFICATION_GROUP) in;
#include "renderer/backends/gpu/invocation.glsl"
layout(set = 0, binding = 2, scalar) buffer Places { uint places[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Keys { uint keys[]; };

void main() {
    const uint k = flat_index();
    if (k >= push.photons) return;
    if (push.high_bits == 0) places[k] = k;
    const uint64_t code = cell_code(photons[order[push.high_bits == 0 ? k : places[k]]]);
    keys[k] = uint(push.high_bits == 0 ? code & 0xfffffffful : code >> 32);
}

#version 460
// How many splats each cell makes, at its first photon. A thread a photon.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PHOTONS_BINDING 0
#define ORDER_BINDING 1
#define KEYS_BINDING 2
#define PLACES_BINDING 3
#include "renderer/methods/photon_splatting/stratification.glsl"

layout(local_size_x = STRATIFICATION_GROUP) in;
#include "renderer/backends/gpu/invocation.glsl"
layout(set = 0, binding = 4, scalar) readonly buffer Covers { uint covers[]; };  // summed
layout(set = 0, binding = 5, scalar) readonly buffer Joined { uint joined[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Splats { uint splats[]; };

uint splats_from(uint k) {
    const uint64_t code = sorted_code(k);
    if (code == no_power()) return 0;
    if (code == outside()) return 1;
    const bool joins = push.minimum_photons > 1;
    if (joins && covers[k] != 0) return 0;
    if (k > 0 && sorted_code(k - 1) == code) return 0;
    if (push.representative >= REPRESENTATIVE_CLOSEST_TO_MEAN) return 1;
    return min(push.splats_per_cell, block_end(k, code, joins ? joined[k] : 0) - k);
}

void main() {
    const uint k = flat_index();
    if (k < push.photons) splats[k] = splats_from(k);
}

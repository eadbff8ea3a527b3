#version 460
// What bounds the photons of each batch, a group a batch, and how many of all have been scattered how often.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/photons/photon.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"

layout(local_size_x = SCATTER_GROUP) in;
layout(push_constant, scalar) uniform Push { PhotonBatchPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { PhotonScatterConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer GridStarts { uint grid_starts[]; };
layout(set = 0, binding = 2, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Batches { PhotonBatch batches[]; };
layout(set = 0, binding = 4, scalar) buffer Bounces { uint photons_by_bounce[PHOTON_BOUNCES]; };

shared uint of_batch[PHOTON_BOUNCES];

#define BOX_GROUP SCATTER_GROUP
#include "renderer/splats/box_of_group.glsl"

void main() {
    const uint batch = flat_index() / SCATTER_GROUP, thread = gl_LocalInvocationIndex;
    if (batch >= push.batches) return;
    const HashGridConstants map = constants.maps[push.map];
    const uint photons = min(grid_starts[map.first_start + map.slots], map.capacity);
    const uint photon = batch * SCATTER_GROUP + thread;
    vec3 low = vec3(INFINITY), high = vec3(-INFINITY);
    if (thread < PHOTON_BOUNCES) of_batch[thread] = 0;
    barrier();
    if (photon < photons) {
        const uvec4 place = grid_places[map.first_point + photon];
        low = high = uintBitsToFloat(place.xyz);
        atomicAdd(of_batch[clamp(photon_scatterings(place.w), 1u, PHOTON_BOUNCES) - 1u], 1u);
    }
    box_of_group(low, high);
    if (thread < PHOTON_BOUNCES && of_batch[thread] > 0) atomicAdd(photons_by_bounce[thread], of_batch[thread]);
    if (thread == 0) batches[constants.first_batch[push.map] + batch] = PhotonBatch(low, high);
}

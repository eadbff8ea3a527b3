#version 460
// The bounce map: where light first arrives, a thread a texel, for photons to leave from (photon_tracing.comp).
//
// [McGuire and Luebke 2009] Hardware-Accelerated Global Illumination by Image Space Photon Mapping. HPG.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#define GUIDE_WORDS_BINDING 2
#define GUIDE_FLOATS_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/photon_paths.glsl"
#include "renderer/photons/photon_tracing_shared.h"

layout(local_size_x = PHOTON_TRACING_GROUP) in;
layout(push_constant, scalar) uniform Push { BounceMapPush push; };
layout(set = 0, binding = 0, scalar) buffer State { uint state[PHOTON_STATE_WORDS]; };
layout(set = 0, binding = 1, scalar) writeonly buffer FirstHits { FirstHit first_hits[]; };

#include "renderer/photons/photon_ray_count.glsl"

FirstHit first_hit_of(uint texel, out bool traced) {
    EmissionSample start;
    FirstHit found = FirstHit(vec3(0.0), 0.0, NO_HIT, 0u, 0.0, 0.0, vec3(0.0), 0.0);
    traced = draw_emission(push.sequence, push.first_element + uint64_t(texel), start);
    if (!traced) return found;
    const Hit hit = closest_hit(start.ray);
    const float arriving = start.range_m < INFINITY ? range_window(hit.t, start.range_m) : 1.0;
    return FirstHit(start.ray.direction, hit.t, hit.instance, hit.triangle, hit.u, hit.v, start.power_w, arriving);
}

void main() {
    const uint texel = push.first_texel + flat_index();
    bool traced = false;
    if (texel < push.end_texel) first_hits[texel] = first_hit_of(texel, traced);
    const uint rays = subgroupAdd(traced ? 1u : 0u);
    if (subgroupElect() && rays > 0) add_photon_rays(rays);
}

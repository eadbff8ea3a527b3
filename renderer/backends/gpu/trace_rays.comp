#version 460
// Rays of a batch: closest hits, or whether anything is met. Host side: device_intersector.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/backends/gpu/trace_rays_shared.h"

layout(local_size_x = TRACE_RAYS_GROUP) in;
layout(constant_id = TRACE_RAYS_ANY_ID) const bool ANY = false;
layout(push_constant, scalar) uniform Push { TraceRaysPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Rays { Ray rays[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Hits { Hit hits[]; };

void main() {
    const uint i = flat_index();
    if (i >= push.count) return;
    const Ray ray = rays[i];
    Hit none;
    none.t = INFINITY, none.instance = NO_HIT, none.triangle = 0, none.u = 0.0, none.v = 0.0;
    if (!(ray.t_max > 0.0)) {
        hits[i] = none;
    } else if (ANY) {
        if (occluded(ray)) none.instance = 0;
        hits[i] = none;
    } else {
        hits[i] = closest_hit(ray);
    }
}

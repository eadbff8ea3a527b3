#version 460
// What texels are worth where an importance is beside their flux: a share by flux alone. CPU twin: VplTracer::trace().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/flux_map.glsl"
#include "renderer/many_lights/vpl_tracer_shared.h"

layout(local_size_x = VPL_GROUP) in;
layout(push_constant, scalar) uniform Push { VplMixPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Flux { float flux[]; };
layout(set = 0, binding = 1, scalar) buffer Weighted { float weighted[]; };

void main() {
    const uint texel = flat_index();
    if (texel >= 1u << (2u * push.levels)) return;
    const uint total = flux_level(push.levels, 1u);
    const float plain = push.plain_share / flux[total], rest = (1.0 - push.plain_share) / weighted[total];
    weighted[texel] = weighted[total] > 0.0 ? plain * flux[texel] + rest * weighted[texel] : flux[texel];
}

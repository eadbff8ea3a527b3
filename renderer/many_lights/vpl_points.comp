#version 460
// Light paths by the points of a Halton set, a thread a path: a pass's, or the candidates for them.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/flux_map.glsl"
#include "renderer/many_lights/vpl_tracer_shared.h"

layout(local_size_x = VPL_GROUP) in;
layout(push_constant, scalar) uniform Push { VplPointsPush push; };
layout(set = 0, binding = 0, scalar) writeonly buffer Paths { VplPath paths[]; };

void main() {
    const uint i = flat_index();
    if (i >= push.paths) return;
    const uvec2 point = rotated_halton_point(i, uvec2(push.rotation_x, push.rotation_y));
    paths[i] = VplPath(point.x, point.y, i, 1.0, 0.0);
}

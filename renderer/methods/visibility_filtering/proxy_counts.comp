#version 460
// How many proxies each triangle has, a thread a triangle.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/visibility_filtering/proxy_placement_shared.h"

layout(local_size_x = PROXY_GROUP) in;
layout(push_constant, scalar) uniform Push { ProxyPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer State { uint state[PROXY_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Counts { uint counts[]; };
#define SVO_FIRST_TRIANGLES_BINDING 1
#define PROXY_PUSH push
#include "renderer/methods/visibility_filtering/proxy_triangles.glsl"

void main() {
    const uint number = flat_index();
    if (number >= state[PROXY_TRIANGLES_WORD]) return;
    const uvec2 which = svo_triangle(number, push.instances);
    const TriangleCorners at = world_triangle(which.x, which.y);
    const float wanted = push.per_m2 * 0.5 * length(cross(at.p[1] - at.p[0], at.p[2] - at.p[0]));
    const bool one_more = to_unit_float(proxy_key(at)) < fract(wanted);
    counts[number] = wanted < 4294967040.0 ? uint(wanted) + (one_more ? 1u : 0u) : 0u;
}

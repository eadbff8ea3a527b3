#version 460
// Depth maps of a batch's beams, traced: CPU twin SplatDepthMaps, which says what they are. A group a splat.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/photon_splatting/splat_shared.h"
#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"

layout(local_size_x = SPLAT_GROUP) in;
layout(push_constant, scalar) uniform Push { SplatClusterPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Splats { Splat splats[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer DepthMaps { float farthest_m[]; };

shared float depth_m[MOST_DEPTH_TEXELS * MOST_DEPTH_TEXELS];

/// What a line of the map goes on by beyond its end.
float beyond(float last, float before, float most_step) { return last + 0.5 * clamp(last - before, 0.0, most_step); }

/// greatest_of_three() of splat_depth_maps.cpp, from `first` on.
void greatest_of_three(uint first, uint stride, uint texels, float most_step) {
    const uint last = first + (texels - 1) * stride;
    const float past_end = beyond(depth_m[last], depth_m[last - stride], most_step);
    float before = beyond(depth_m[first], depth_m[first + stride], most_step);
    for (uint i = 0; i < texels; ++i) {
        const uint at = first + i * stride;
        const float here = depth_m[at];
        const float after = i + 1 < texels ? depth_m[at + stride] : past_end;
        depth_m[at] = max(max(before, here), after);
        before = here;
    }
}

void trace_map(uint index, Splat splat) {
    const uint side = constants.shadow_resolution, texels = side * side;
    const float texel_m = 2.0 * splat.radius / float(side);
    const float depth = max(splat.far_m - splat.near_m, 1e-6 * splat.radius);
    const Frame axes = make_frame(splat.axis);
    const vec3 near_centre = splat.origin + splat.near_m * splat.axis;
    for (uint texel = gl_LocalInvocationIndex; texel < texels; texel += SPLAT_GROUP) {
        const vec2 across = (vec2(texel % side, texel / side) + 0.5) * texel_m - splat.radius;
        const vec3 start = near_centre + across.y * axes.bitangent + across.x * axes.tangent;
        depth_m[texel] = min(closest_hit(Ray(start, splat.axis, depth)).t, depth);
    }
    barrier();
    // Rows, then columns: no side is longer than the group.
    if (gl_LocalInvocationIndex < side) greatest_of_three(gl_LocalInvocationIndex * side, 1, side, SPLAT_MOST_SLOPE * texel_m);
    barrier();
    if (gl_LocalInvocationIndex < side) greatest_of_three(gl_LocalInvocationIndex, side, side, SPLAT_MOST_SLOPE * texel_m);
    barrier();
    for (uint texel = gl_LocalInvocationIndex; texel < texels; texel += SPLAT_GROUP)
        farthest_m[index * texels + texel] = depth_m[texel] + texel_m;
    if (gl_LocalInvocationIndex == 0) count(COUNTER_SHADOW_RAYS, texels);
}

void main() {
    const uint index = push.first_splat + flat_index() / SPLAT_GROUP;
    if (index < push.end_splat && (splats[index].kind & SPLAT_KIND_MASK) == SPLAT_BEAM) trace_map(index, splats[index]);
}

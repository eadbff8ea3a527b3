#version 460
// What was drawn over the pixels, to their visible points. A thread a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/photon_splatting/splat_shared.h"
#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"

layout(local_size_x = SPLAT_GROUP) in;
layout(push_constant, scalar) uniform Push { uint pixels; } push;
layout(set = 0, binding = 1, scalar) readonly buffer Heads { uint first_of_pixel[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Light { vec4 light_and_splats[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Weights { vec2 weight_and_contributions[]; };
layout(set = 0, binding = 4, scalar) buffer Sums { SplatSum sums[]; };

void main() {
    const uint pixel = flat_index();
    uint contributions = 0;
    if (pixel < push.pixels && first_of_pixel[pixel] != NO_POINT) {
        const vec4 light = light_and_splats[pixel];
        const vec2 weight = weight_and_contributions[pixel];
        sums[first_of_pixel[pixel]] = SplatSum(light.xyz, light.w, weight.x);
        contributions = uint(weight.y);
    }
    count(COUNTER_SPLAT_CONTRIBUTIONS, contributions);
}

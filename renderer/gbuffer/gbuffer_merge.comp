#version 460
// What the points of a G-buffer were lit by, brought into the image, a thread a pixel: CPU twin SvoManyLights::merge().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/gbuffer/gbuffer_walk_shared.h"
#include "renderer/frame/device_image.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { SplitRecord split; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Sums { vec3 sums[]; };

void main() {
    const uint pixel = flat_index();
    if (pixel >= split.width * split.height) return;
    const uint index = split_point_of(split, pixel % split.width, pixel / split.width);
    if (points[index].kind != 0u) add_rgb(PLANE_INDIRECT, pixel, points[index].weight * sums[index]);
}

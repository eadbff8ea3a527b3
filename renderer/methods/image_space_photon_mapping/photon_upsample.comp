#version 460
// Light of the pixels that have none of their own, a thread a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/backends/gpu/scene.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"

layout(local_size_x = SCATTER_GROUP) in;
layout(set = 0, binding = 0, scalar) readonly buffer Constants { PhotonScatterConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) buffer Sums { vec3 sums[]; };
#define SUB_POINTS points
#include "renderer/methods/image_space_photon_mapping/upsampling.glsl"

void main() {
    const SplitRecord split = constants.split;
    const uint pixel = flat_index();
    if (pixel >= split.width * split.height) return;
    const uint x = pixel % split.width, y = pixel / split.width, index = split_point_of(split, x, y);
    const GBufferPoint point = points[index];
    if (!is_lit(point) || lights_itself(split, x, y, point, constants.radius_m)) return;
    const SubSamples from = sub_samples_of(split, x, y, point, constants.radius_m);
    vec3 light = vec3(0.0);
    for (int i = 0; i < 4; ++i)
        if (from.weights[i] > 0.0) light += from.weights[i] * sums[from.points[i]];
    sums[index] = light / from.total;
}

#version 460
// What the points of a G-buffer were lit by, brought into the image, a thread a pixel: CPU twin SvoManyLights::merge().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/gbuffer/gbuffer_pixels.glsl"

void main() {
    uint pixel;
    if (!pixel_of_thread(pixel)) return;
    const uint index = split_point_of(split, pixel % split.width, pixel / split.width);
    if (points[index].kind != 0u) add_rgb(LAYER_INDIRECT, pixel, points[index].weight * sums[index]);
}

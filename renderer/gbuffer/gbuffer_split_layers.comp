#version 460
// The split buffer as it lies, for the layers `split_normal` and `split_indirect`, a thread a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/gbuffer/gbuffer_pixels.glsl"

void main() {
    uint pixel;
    if (!pixel_of_thread(pixel)) return;
    const uint index = split_point_shown_at(split, pixel % split.width, pixel / split.width);
    if (layer_kept(LAYER_SPLIT_NORMAL)) store_rgb(LAYER_SPLIT_NORMAL, pixel, points[index].normal);
    if (layer_kept(LAYER_SPLIT_INDIRECT)) store_rgb(LAYER_SPLIT_INDIRECT, pixel, sums[index]);
}

#version 460
// Holes of a level from the coarser one: bilinear among what is of the surface nearest by.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/imperfect_level.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Coarse { float coarse_m[]; };
layout(set = 0, binding = 2, scalar) buffer Fine { float fine_m[]; };

void main() {
    uint light;
    uvec2 at;
    if (!level_texel(push.fine_side, light, at) || !isinf(fine_m[flat_index()])) return;
    // The parent, and those beside it on the texel's side.
    const ivec2 parent = ivec2(at / 2), aside = ivec2(at % 2) * 2 - 1;
    float values[4], of_surface = INFINITY;
    for (int i = 0; i < 4; ++i) {
        const ivec2 from = parent + aside * ivec2(i & 1, i >> 1);
        const bool inside = all(greaterThanEqual(from, ivec2(0))) && all(lessThan(from, ivec2(push.coarse_side)));
        values[i] = inside ? coarse_m[(light * push.coarse_side + from.y) * push.coarse_side + from.x] : INFINITY;
        if (isinf(of_surface)) of_surface = values[i];
    }
    const float weights[4] = {9.0, 3.0, 3.0, 1.0};
    float sum = 0.0, weight = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (isinf(values[i]) || abs(values[i] - of_surface) > SAME_SURFACE * of_surface) continue;
        sum += weights[i] * values[i];
        weight += weights[i];
    }
    if (weight > 0.0) fine_m[flat_index()] = sum / weight;
}

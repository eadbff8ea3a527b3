#version 460
// A level of the pyramid from the finer one: the mean of the nearest surface's distances among four.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/imperfect_level.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Fine { float fine_m[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Coarse { float coarse_m[]; };

void main() {
    uint light;
    uvec2 at;
    if (!level_texel(push.coarse_side, light, at)) return;
    float values[4], nearest = INFINITY;
    for (uint i = 0; i < 4; ++i) {
        const uvec2 from = 2 * at + uvec2(i & 1, i >> 1);
        const bool inside = max(from.x, from.y) < push.fine_side;
        values[i] = inside ? fine_m[(light * push.fine_side + from.y) * push.fine_side + from.x] : INFINITY;
        nearest = min(nearest, values[i]);
    }
    float sum = 0.0, alike = 0.0;
    for (uint i = 0; i < 4; ++i) {
        if (isinf(values[i]) || values[i] > nearest * (1.0 + SAME_SURFACE)) continue;
        sum += values[i];
        alike += 1.0;
    }
    coarse_m[flat_index()] = alike > 0.0 ? sum / alike : INFINITY;
}

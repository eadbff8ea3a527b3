#version 460
// Angles and their sines.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/core/angles.glsl"
#include "tests/gpu/twin.glsl"

struct Answer {
    float angle;   // of the point (x, y)
    vec2 sin_cos;  // of its x
};
layout(set = 0, binding = 0, scalar) readonly buffer In { vec2 points[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    answers[i] = Answer(atan2(points[i].y, points[i].x), sin_cos(points[i].x));
}

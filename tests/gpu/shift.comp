#version 460
// One more than the next element, around the end; and its own record of how often it was run.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "tests/gpu/twin.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer In { uint from[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { uint to[]; };
layout(set = 0, binding = 2, scalar) buffer Runs { uint runs[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    to[i] = from[i + 1 < count ? i + 1 : 0] + 1;
    ++runs[i];
}

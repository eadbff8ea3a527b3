#version 460
// Unit normals of two edges.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/surface.glsl"
#include "tests/gpu/twin.glsl"

struct Edges {
    vec3 a, b;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Edges edges[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { vec3 normals[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    normals[i] = unit_cross(edges[i].a, edges[i].b);
}

#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/many_lights/vpl_tree.glsl"
#include "tests/gpu/twin.glsl"

struct Question {
    vec3 position;
    float clamp_sq_m2;
    vec3 normal;
};
layout(set = 0, binding = 0, scalar) readonly buffer Nodes { VplTreeNode nodes[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Questions { Question questions[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Bounds { float bounds[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    bounds[i] = vpl_bound(nodes[i], questions[i].position, questions[i].normal, questions[i].clamp_sq_m2);
}

#version 460
// Segments and rays against a voxel tree.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define SVO_CONSTANTS_BINDING 1
#define SVO_NODES_BINDING 2
#define SVO_BRICKS_BINDING 3
#define SVO_SURFACES_BINDING 4
#include "renderer/voxels/svo_march.glsl"
#include "tests/gpu/twin.glsl"

struct Question {
    Ray ray;
    vec3 a, normal_a, b, normal_b;
};
struct Answer {
    uint hit;
    float t;
    uvec3 voxel;
    uint surface;
    uint occluded;
    uint occluded_blind;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Question questions[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Question question = questions[i];
    Answer answer;
    answer.hit = svo_first_voxel(question.ray, answer.t, answer.voxel, answer.surface) ? 1u : 0u;
    answer.occluded = svo_occluded(question.a, question.normal_a, question.b, question.normal_b) ? 1u : 0u;
    answer.occluded_blind = svo_occluded(question.a, question.b) ? 1u : 0u;
    answers[i] = answer;
}

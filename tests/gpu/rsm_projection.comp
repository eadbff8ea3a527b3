#version 460
// Where points are in their lights' maps.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/reflective_shadow_maps/rsm_projection.glsl"
#include "tests/gpu/twin.glsl"

struct Question {
    uint light;
    vec3 point;
};
layout(set = 0, binding = 0, scalar) readonly buffer Questions { Question questions[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Answers { vec3 answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const RsmProjection to = project_to_light(questions[i].light, questions[i].point);
    answers[i] = vec3(to.place, to.local ? 1.0 : 0.0);
}

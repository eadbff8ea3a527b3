#version 460
// What shafts say of segments, and what of the segments they may stand in.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "tests/gpu/twin.glsl"
#define SHAFT_MOST_BLOCKERS 8
shared uint blockers[TWIN_GROUP * SHAFT_MOST_BLOCKERS];
#define SHAFT_BLOCKERS blockers
#include "renderer/transport/shaft_visibility.glsl"

struct Question {
    vec3 apex;
    vec3 apex_normal;
    ShaftTarget target;
    vec3 from;
    vec3 to;
};
struct Answer {
    uint blockers;
    uint cut;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Question questions[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Question question = questions[i];
    const uint place = gl_LocalInvocationIndex;
    const uint found = shaft_blockers(question.apex, question.apex_normal, question.target, place);
    const bool known = found <= SHAFT_MOST_BLOCKERS;
    answers[i] = Answer(found, known && shaft_cut(place, found, question.from, question.to) ? 1u : 0u);
}

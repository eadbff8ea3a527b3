#version 460
// What the lights' depth maps say of points.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define LIGHT_DEPTH_CONSTANTS_BINDING 0
#define LIGHT_DEPTH_MAPS_BINDING 1
#define LIGHT_DEPTHS_BINDING 2
#include "renderer/gbuffer/light_depth_maps.glsl"
#include "tests/gpu/twin.glsl"

struct Question {
    vec3 position;
    vec3 normal;
    vec2 u;
    uint source;
};
struct Answer {
    uint seen;  // LightSeen
    vec2 tap_number;
};
layout(set = 0, binding = 3, scalar) readonly buffer Questions { Question questions[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Answers { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Question asked = questions[i];
    uint seen = 2;
    if (light_depth_known(asked.source))
        seen = light_depth_lit(asked.source, asked.position, asked.normal, asked.u) ? 0 : 1;
    answers[i] = Answer(seen, light_depth_tap_number(asked.position, asked.source, i));
}

#version 460
// Points as a camera sees them.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/eye/camera_connection.glsl"
#include "tests/gpu/twin.glsl"

struct Query {
    vec3 point;
    vec2 lens;
    vec3 direction;
};
struct Answer {
    CameraConnection seen;
    float direction_pdf;
    uint valid;
};
layout(set = 0, binding = 0, scalar) readonly buffer Cameras { CameraConstants camera; };
layout(set = 0, binding = 1, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query q = queries[i];
    Answer answer;
    answer.valid = camera_connect(camera, q.point, q.lens, answer.seen) ? 1u : 0u;
    answer.direction_pdf = camera_pdf(camera, q.direction);
    answers[i] = answer;
}

#version 460
// Weights of all ways to join two sub-paths of two surfaces each, whose densities are given.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/bidirectional/mis_weights.glsl"
#include "tests/gpu/twin.glsl"

struct Query {
    TechniqueNumbers numbers;
    float direct;  // of the light's end
    float emission;
    float cosine;
    uint delta;
    uint infinite;
    float camera_pdf;
    // Of each sub-path, the light's first.
    float distance_sq[4];
    float cos_in[4];
    float pdf_back[4];
    float acceptance[4];
    float pdf[2];
    float cos_out[2];
    uint delta_scattering[2];
    float more[4];  // densities that the ways ask for besides
};
struct Answer {
    float light_met;
    float next_event;
    float seen_by_camera;
    float connection;
    float merging;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Answer answers[]; };

VertexSide side_of(Query q, uint vertex) {
    return VertexSide(vertex % 2 == 0, q.pdf_back[vertex], q.acceptance[vertex]);
}

void follow(Query q, uint path, inout SubpathWeights w) {
    mis_arrive(w, q.distance_sq[2 * path], q.cos_in[2 * path]);
    if (q.delta_scattering[path] != 0)
        mis_scatter_delta(w, q.cos_out[path]);
    else
        mis_scatter(w, side_of(q, 2 * path), q.pdf[path], q.cos_out[path]);
    mis_arrive(w, q.distance_sq[2 * path + 1], q.cos_in[2 * path + 1]);
}

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query q = queries[i];
    const LightEnd end = LightEnd(q.direct, q.emission, q.cosine, q.delta != 0, q.infinite != 0);
    SubpathWeights light = mis_start_light(end);
    mis_direct_at_first_hit(light, q.direct);
    follow(q, 0, light);
    SubpathWeights of_eye = mis_start_eye(q.camera_pdf);
    follow(q, 1, of_eye);
    const VertexSide light_side = side_of(q, 1), eye_side = side_of(q, 3);
    answers[i] = Answer(mis_light_met(of_eye, end, q.numbers),
                        mis_next_event(of_eye, eye_side, q.more[0], q.more[1], q.more[2], end, q.numbers),
                        mis_seen_by_camera(light, light_side, q.more[3], q.numbers),
                        mis_connection(of_eye, eye_side, q.more[0], light, light_side, q.more[1], q.numbers),
                        mis_merging(of_eye, eye_side, light, light_side, q.numbers));
}

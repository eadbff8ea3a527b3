// GLSL twin of bidirectional/mis_weights.h: weights of multiple importance sampling among all ways to make one path. What
// the sums are, and the reasons for each step, are said there.
#ifndef PHOTOND_MIS_WEIGHTS_GLSL
#define PHOTOND_MIS_WEIGHTS_GLSL

#include "renderer/bidirectional/mis_weights_shared.h"
#include "renderer/transport/light_ends.glsl"

layout(constant_id = MIS_POWER_ID) const bool MIS_POWER = false;

/// One side of a vertex that two sub-paths meet at.
struct VertexSide {
    bool first_surface;  // of its sub-path
    float pdf_back;      // [1/sr] of scattering back along the sub-path, for a path that comes the other way
    float acceptance;    // of merging here: pi r^2 [m^2]
};

float mis_of(float ratio) { return MIS_POWER ? ratio * ratio : ratio; }
float mis_weight(float own, float others) {
    const float share = own / (own + others);
    return share >= 0.0 ? share : 0.0;  // not where densities leave the range of float
}

/// Merging at a vertex.
float mis_merge(VertexSide side, TechniqueNumbers n) {
    return n.merges != 0 ? mis_of(n.light_paths * side.acceptance) : 0.0;
}
float mis_sum_of_light(SubpathWeights w, TechniqueNumbers n) {
    return w.ends + mis_of(n.connections) * w.connections + (n.merges != 0 ? mis_of(n.light_paths) * w.merges : 0.0);
}
float mis_sum_of_eye(SubpathWeights w, TechniqueNumbers n) {
    return mis_of(n.light_paths) * (w.ends + (n.merges != 0 ? w.merges : 0.0)) + mis_of(n.connections) * w.connections;
}
float mis_others_of_light(SubpathWeights w, VertexSide side, TechniqueNumbers n) {
    return (side.first_surface ? w.last : mis_of(n.connections) * w.last) +
           mis_of(side.pdf_back) * mis_sum_of_light(w, n);
}
float mis_others_of_eye(SubpathWeights w, VertexSide side, TechniqueNumbers n) {
    return mis_of(side.first_surface ? n.light_paths : n.connections) * w.last +
           mis_of(side.pdf_back) * mis_sum_of_eye(w, n);
}

SubpathWeights mis_start_light(LightEnd end) {
    return SubpathWeights(mis_of(1.0 / end.emission),
                          end.delta ? 0.0 : mis_of((end.infinite ? 1.0 : end.cosine) / end.emission), 0.0, 0.0, 0.0);
}
void mis_direct_at_first_hit(inout SubpathWeights w, float direct) { w.last *= mis_of(direct); }
SubpathWeights mis_start_eye(float camera_pdf) { return SubpathWeights(mis_of(1.0 / camera_pdf), 0.0, 0.0, 0.0, 0.0); }

void mis_arrive(inout SubpathWeights w, float distance_sq_m2, float cos_at_surface) {
    const float inverse_cos = mis_of(1.0 / cos_at_surface);
    w.last *= mis_of(distance_sq_m2) * inverse_cos;
    w.ends *= inverse_cos;
    w.connections *= inverse_cos;
    w.merges *= inverse_cos;
    w.newest_merge *= inverse_cos;
}
void mis_scatter(inout SubpathWeights w, VertexSide side, float pdf, float cos_out) {
    const float outward = mis_of(cos_out / pdf), back = mis_of(side.pdf_back);
    w.ends = outward * (w.ends * back + (side.first_surface ? w.last : 0.0));
    w.connections = outward * (w.connections * back + (side.first_surface ? 0.0 : w.last));
    w.newest_merge = outward * mis_of(side.acceptance);
    w.merges = outward * (w.merges * back) + w.newest_merge;
    w.last = mis_of(1.0 / pdf);
}
void mis_scatter_delta(inout SubpathWeights w, float cos_out) {
    const float outward = mis_of(cos_out);
    w.last = 0.0;
    w.ends *= outward;
    w.connections *= outward;
    w.merges *= outward;
    w.newest_merge *= outward;
}

float mis_light_met(SubpathWeights eye, LightEnd end, TechniqueNumbers n) {
    const bool by_delta = eye.last == 0.0;
    if (by_delta) eye.merges -= eye.newest_merge * (1.0 - mis_of(sqr(n.caustic_radius)));
    return mis_weight(1.0, mis_of(end.direct) * eye.last + mis_of(end.emission) * mis_sum_of_eye(eye, n));
}
float mis_next_event(SubpathWeights eye, VertexSide side, float pdf, float pdf_direct_sa, float cosine, LightEnd end,
                     TechniqueNumbers n) {
    const float by_bsdf = end.delta ? 0.0 : mis_of(pdf / pdf_direct_sa);
    const float emitted = mis_of(end.emission * cosine / (pdf_direct_sa * end.cosine));
    return mis_weight(1.0, by_bsdf + emitted * (mis_merge(side, n) + mis_others_of_eye(eye, side, n)));
}
float mis_seen_by_camera(SubpathWeights light, VertexSide side, float camera_pdf_area, TechniqueNumbers n) {
    return mis_weight(mis_of(n.light_paths),
                      mis_of(camera_pdf_area) * (mis_merge(side, n) + mis_others_of_light(light, side, n)));
}
float mis_connection(SubpathWeights eye, VertexSide eye_side, float to_light_pdf_area, SubpathWeights light,
                     VertexSide light_side, float to_eye_pdf_area, TechniqueNumbers n) {
    return mis_weight(
        mis_of(n.connections),
        mis_of(to_light_pdf_area) * (mis_merge(light_side, n) + mis_others_of_light(light, light_side, n)) +
            mis_of(to_eye_pdf_area) * (mis_merge(eye_side, n) + mis_others_of_eye(eye, eye_side, n)));
}
float mis_merging(SubpathWeights eye, VertexSide eye_side, SubpathWeights light, VertexSide light_side,
                  TechniqueNumbers n) {
    return mis_weight(mis_merge(eye_side, n),
                      mis_others_of_light(light, light_side, n) + mis_others_of_eye(eye, eye_side, n));
}

#endif

#version 460
// Photons scattered at one place, and the density they are drawn from.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/photon_scattering.glsl"
#include "tests/gpu/twin.glsl"

struct Place {
    Hit hit;
    float outside_ior;
    uint part;  // 0: the whole BSDF, 1: its specular part, 2: its rough part
    float glossy_threshold;
};
struct Query {
    vec3 wi;
    vec3 numbers;   // u_lobe, u
    vec3 outgoing;  // to ask the density of
};
struct Answer {
    PhotonScattering scattering;
    vec3 density;
    float density_pdf_sa;
};
layout(set = 0, binding = 0, scalar) readonly buffer Places { Place place; };
layout(set = 0, binding = 1, scalar) readonly buffer In { Query queries[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Query query = queries[i];
    const ShadingPoint point = make_shading_point(place.hit, -query.wi);
    Bsdf bsdf = make_bsdf(point, place.outside_ior);
    if (place.part == 1) bsdf = bsdf_specular_part(bsdf, place.glossy_threshold);
    if (place.part == 2) bsdf = bsdf_rough_part(bsdf, place.glossy_threshold);
    answers[i] = Answer(scatter_photon(point, bsdf, query.wi, query.numbers.x, query.numbers.yz),
                        scatter_density(point, bsdf, query.wi, query.outgoing),
                        scatter_pdf(point, bsdf, query.wi, query.outgoing));
}

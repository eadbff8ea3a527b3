#version 460
// What BSDFs say of themselves.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "tests/gpu/bsdf.glsl"
#include "tests/gpu/twin.glsl"

struct BsdfTraits {
    vec3 albedo;
    float refraction_eta;
    bool scatters, is_lambert, has_non_delta, has_delta, has_non_delta_transmission, is_diffuse;
};
layout(set = 0, binding = 0, scalar) readonly buffer Cases { BsdfCase cases[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { BsdfTraits traits[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Bsdf bsdf = make_case(cases[i]);
    traits[i] = BsdfTraits(bsdf_albedo(bsdf), bsdf_refraction_eta(bsdf), bsdf_scatters(bsdf), bsdf_is_lambert(bsdf),
                           bsdf_has_non_delta(bsdf), bsdf_has_delta(bsdf), bsdf_has_non_delta_transmission(bsdf),
                           bsdf_is_diffuse(bsdf));
}

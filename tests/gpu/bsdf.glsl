// What the shaders of the BSDF's tests read: tests/support/gpu_bsdf.cpp has the same structs.
#ifndef PHOTOND_TEST_BSDF_GLSL
#define PHOTOND_TEST_BSDF_GLSL

#include "renderer/transport/bsdf.glsl"

struct BsdfCase {
    BsdfParameters parameters;
    uint part;  // 0: the whole, 1: its specular part, 2: its rough part
    float glossy_threshold;
    uint mode;
};
struct BsdfQuery {
    uint bsdf_case;
    vec3 wo;
    vec3 w;  // a direction to evaluate, or three numbers to sample by: u_lobe, u
};

Bsdf make_case(BsdfCase c) {
    const Bsdf bsdf = bsdf_layered(c.parameters);
    if (c.part == 1) return bsdf_specular_part(bsdf, c.glossy_threshold);
    if (c.part == 2) return bsdf_rough_part(bsdf, c.glossy_threshold);
    return bsdf;
}

#endif

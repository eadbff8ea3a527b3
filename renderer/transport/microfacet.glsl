// GLSL twin of transport/microfacet.h: the GGX distribution, isotropic, with Smith's shadowing. Directions are local (+z
// the mean normal). References and reasons are there.
#ifndef PHOTOND_MICROFACET_GLSL
#define PHOTOND_MICROFACET_GLSL

#include "renderer/core/geometry.glsl"

struct Ggx {
    float alpha;
};

/// Density of micro-normals over projected area [sr^-1]; h.z > 0.
float ggx_d(Ggx ggx, vec3 h) {
    const float a2 = sqr(ggx.alpha);
    return a2 / (PI * sqr(a2 * sqr(h.z) + sqr(h.x) + sqr(h.y)));
}

/// sqrt(cos^2 + alpha^2 sin^2): (1 + 2 Lambda) |cos|.
float ggx_stretched_cos(Ggx ggx, vec3 w) { return sqrt(sqr(w.z) + sqr(ggx.alpha) * (sqr(w.x) + sqr(w.y))); }

/// Masking over cosine, G1(w) / |cos(w)| [Heitz 2014, Eq. 43, 72].
float ggx_g1_over_cos(Ggx ggx, vec3 w) { return 2.0 / (abs(w.z) + ggx_stretched_cos(ggx, w)); }

/// Height-correlated masking and shadowing over both cosines, G2 / (cos(wo) cos(wi)) [Heitz 2014, Eq. 99]; both
/// directions above the surface.
float ggx_g2_over_cosines(Ggx ggx, vec3 wo, vec3 wi) {
    return 2.0 / (wo.z * ggx_stretched_cos(ggx, wi) + wi.z * ggx_stretched_cos(ggx, wo));
}

/// A micro-normal visible from wo (wo.z > 0), of density visible_pdf [Dupuy and Benyoub 2023, listing 3].
vec3 ggx_sample_visible(Ggx ggx, vec3 wo, vec2 u) {
    const vec3 w = normalize(vec3(ggx.alpha * wo.x, ggx.alpha * wo.y, wo.z));
    const float phi = 2.0 * PI * u.x;
    const float z = (1.0 - u.y) * (1.0 + w.z) - w.z;
    const float r = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    const vec3 h = vec3(r * cos(phi), r * sin(phi), z) + w;
    return normalize(vec3(ggx.alpha * h.x, ggx.alpha * h.y, max(h.z, 1e-7)));
}

/// Density [sr^-1] of ggx_sample_visible(); dot(wo, h) > 0.
float ggx_visible_pdf(Ggx ggx, vec3 wo, vec3 h) {
    return ggx_g1_over_cos(ggx, wo) * ggx_d(ggx, h) * max(0.0, dot(wo, h));
}

/// Density [sr^-1] of wo mirrored at ggx_sample_visible(): visible_pdf / (4 dot(wo, h)).
float ggx_reflection_pdf(Ggx ggx, vec3 wo, vec3 h) { return 0.25 * ggx_g1_over_cos(ggx, wo) * ggx_d(ggx, h); }

#endif

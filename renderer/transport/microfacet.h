#pragma once
// The GGX microfacet distribution, isotropic, with Smith's shadowing. Directions are local (+z the mean normal). All
// formulas are written with sines taken from x and y: cosines near 1 cannot tell the directions of narrow lobes apart.
//
// [Heitz 2014] Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs. JCGT 3(2).
// [Heitz 2018] Sampling the GGX Distribution of Visible Normals. JCGT 7(4).
// [Dupuy and Benyoub 2023] Sampling Visible GGX Normals with Spherical Caps. HPG.

#include <algorithm>

#include "renderer/core/geometry.h"

namespace photond {

struct Ggx {
    float alpha;

    /// Density of micro-normals over projected area [sr^-1]; h.z > 0.
    float d(const vec3& h) const {
        const float a2 = sqr(alpha);
        return a2 / (kPi * sqr(a2 * sqr(h.z) + sqr(h.x) + sqr(h.y)));
    }

    /// sqrt(cos^2 + alpha^2 sin^2): (1 + 2 Lambda) |cos|, finite at grazing angles where Lambda is not.
    float stretched_cos(const vec3& w) const { return std::sqrt(sqr(w.z) + sqr(alpha) * (sqr(w.x) + sqr(w.y))); }

    /// Masking over cosine, G1(w) / |cos(w)| [Heitz 2014, Eq. 43, 72].
    float g1_over_cos(const vec3& w) const { return 2.0f / (std::fabs(w.z) + stretched_cos(w)); }

    /// Height-correlated masking and shadowing over both cosines, G2 / (cos(wo) cos(wi)) [Heitz 2014, Eq. 99]; both
    /// directions above the surface.
    float g2_over_cosines(const vec3& wo, const vec3& wi) const {
        return 2.0f / (wo.z * stretched_cos(wi) + wi.z * stretched_cos(wo));
    }

    /// A micro-normal visible from wo (wo.z > 0), of density visible_pdf [Dupuy and Benyoub 2023, listing 3].
    vec3 sample_visible(const vec3& wo, vec2 u) const {
        const vec3 w = glm::normalize(vec3(alpha * wo.x, alpha * wo.y, wo.z));
        const float phi = 2.0f * kPi * u.x;
        const float z = (1.0f - u.y) * (1.0f + w.z) - w.z;
        const float r = std::sqrt(std::clamp(1.0f - z * z, 0.0f, 1.0f));
        const vec3 h = vec3(r * std::cos(phi), r * std::sin(phi), z) + w;
        return glm::normalize(vec3(alpha * h.x, alpha * h.y, std::max(h.z, 1e-7f)));
    }

    /// Density [sr^-1] of sample_visible(); dot(wo, h) > 0.
    float visible_pdf(const vec3& wo, const vec3& h) const {
        return g1_over_cos(wo) * d(h) * std::max(0.0f, glm::dot(wo, h));
    }

    /// Density [sr^-1] of wo mirrored at sample_visible(): visible_pdf / (4 dot(wo, h)).
    float reflection_pdf(const vec3& wo, const vec3& h) const { return 0.25f * g1_over_cos(wo) * d(h); }
};

}  // namespace photond

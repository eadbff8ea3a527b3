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

    /// What the lobe reflects of uniform light towards wo (wo.y = 0), facets having the reflectance f(dot(wo, h)): the
    /// mean over a grid of visible normals, each weighing G2 / G1(wo). Half the azimuths are enough, as the lobe is
    /// symmetric about the plane of incidence. The caps crowd towards grazing normals (u = 1 - v^3), few of which are
    /// drawn and whose reflections leave through the horizon. `staggered`: those of each azimuth lie elsewhere, for an
    /// f with a step.
    template <class Value, class Reflectance>
    Value directional_albedo(const vec3& wo, int azimuths, int caps, bool staggered, const Reflectance& f) const {
        const float g1 = g1_over_cos(wo);
        Value sum(0);
        for (int i = 0; i < azimuths; ++i) {
            const float turn = (static_cast<float>(i) + 0.5f) / static_cast<float>(2 * azimuths);
            const float within = staggered ? std::fmod(0.618034f * (static_cast<float>(i) + 0.5f), 1.0f) : 0.5f;
            for (int j = 0; j < caps; ++j) {
                const float v = (static_cast<float>(j) + within) / static_cast<float>(caps);
                const vec3 h = sample_visible(wo, {turn, 1.0f - v * v * v});
                const float cos_h = glm::dot(wo, h);
                const vec3 wi = 2.0f * cos_h * h - wo;
                if (wi.z <= 0) continue;
                sum += 3.0f * v * v * g2_over_cosines(wo, wi) * wi.z / g1 * f(cos_h);
            }
        }
        return sum / static_cast<float>(azimuths * caps);
    }
};

}  // namespace photond

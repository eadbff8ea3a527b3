// GLSL twin of transport/bsdf.h and bsdf.cpp: the lobes, their equations and their references are described there.
// Directions are local to the shading frame, unit, and leave the surface.
#ifndef PHOTOND_BSDF_GLSL
#define PHOTOND_BSDF_GLSL

#include "renderer/backends/gpu/scene.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/scene/delta_shared.h"
#include "renderer/transport/bsdf_albedo_table.glsl"
#include "renderer/transport/fresnel.glsl"
#include "renderer/transport/microfacet.glsl"
#include "renderer/transport/sampling.glsl"

// TransportMode.
#define TRANSPORT_RADIANCE 0u
#define TRANSPORT_IMPORTANCE 1u

/// f(wo, wi) |cos(wi)| [sr^-1], and the density [sr^-1] with which bsdf_sample(wo) finds wi. Delta lobes are not in
/// either.
struct BsdfValue {
    vec3 f_cos;
    float pdf_sa;
};
const BsdfValue NO_BSDF_VALUE = BsdfValue(vec3(0.0), 0.0);

/// One sampled direction. A sample with pdf_sa = 0 is to be dropped (the path ends).
struct BsdfSample {
    vec3 wi;
    vec3 weight;   // f |cos| / pdf; of a delta lobe its reflectance over its probability
    float pdf_sa;  // what bsdf_evaluate() says; of a delta lobe the probability of having chosen it, no density
    bool delta;
    bool transmission;  // wi is on the other side
    bool refraction;    // ... and inside (or outside) of a solid: the medium changed
    float eta;          // refraction: index on wi's side over that on wo's side; else 1
};
const BsdfSample NO_BSDF_SAMPLE = BsdfSample(vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, false, false, false, 1.0);

bool bsdf_sample_valid(BsdfSample s) { return s.pdf_sa > 0; }

// Bsdf::flags: its kind (neither of the first two: it scatters nothing), and what classify_lobes() finds.
#define BSDF_LAMBERT 1u
#define BSDF_LAYERED 2u
#define BSDF_SOLID 4u           // `tint` is that of what the solid refracts, else the thin sheet's
#define BSDF_SPECULAR_DELTA 8u  // and the sheet's
#define BSDF_GLASS_DELTA 16u
#define BSDF_HAS_NON_DELTA 32u
#define BSDF_HAS_DELTA 64u
#define BSDF_HAS_NON_DELTA_TRANSMISSION 128u

/// Scattering at a surface, made anew at each hit. Only the first three fields are looked at of a Lambert reflector.
struct Bsdf {
    uint flags;
    vec3 geometric_normal;
    vec3 diffuse;  // layered: over 1 - E_avg
    // Bsdf::Layers. A surface is a sheet or a solid: one tint serves both.
    float alpha;
    float table_row;
    vec3 specular_f0;
    float specular_f90;
    float coat_f0;  // of the dielectric alone, its greatest channel: what the diffuse lobe and the sheet lie under
    float coat_f90;
    vec3 tint;
    float glass;           // share of the solid's interface
    vec3 glass_color;      // specular_color of the interface; white towards grazing angles
    float glass_specular;  // share of the interface that reflects at all
    float eta;
};

/// Scatters nothing (unlit surfaces).
Bsdf bsdf_nothing() {
    return Bsdf(0u, vec3(0.0, 0.0, 1.0), vec3(0.0), 1.0, 0.0, vec3(0.0), 0.0, 0.0, 0.0, vec3(0.0), 0.0, vec3(1.0), 1.0,
                1.0);
}

/// `geometric_normal` local; `reflectance` in [0, 1].
Bsdf bsdf_lambert(vec3 geometric_normal, vec3 reflectance) {
    Bsdf bsdf = bsdf_nothing();
    bsdf.flags = BSDF_LAMBERT;
    bsdf.geometric_normal = geometric_normal;
    bsdf.diffuse = reflectance;
    return bsdf;
}

/// Bsdf::Parameters: everything that the layered lobes are made of; all factors in [0, 1] unless said.
struct BsdfParameters {
    vec3 geometric_normal;  // local
    vec3 base_color;
    float metallic;
    float roughness;  // alpha is its square
    float ior;        // of the coat against air; >= 1, or 0 for F0 = 1
    float specular;
    vec3 specular_color;  // >= 0, may exceed 1
    float transmission;
    bool solid;  // transmission is by refraction, else that of a thin sheet
    float eta;   // solid: index on the far side over that on the eye's side; 0 reflects all
};

bool bsdf_is(Bsdf bsdf, uint flag) { return (bsdf.flags & flag) != 0u; }
bool bsdf_is_layered(Bsdf bsdf) { return !ONLY_LAMBERT && bsdf_is(bsdf, BSDF_LAYERED); }
bool bsdf_specular_delta(Bsdf bsdf) { return NEEDS_DELTA && (!NEEDS_GLOSSY || bsdf_is(bsdf, BSDF_SPECULAR_DELTA)); }
bool bsdf_glass_delta(Bsdf bsdf) { return bsdf_is(bsdf, BSDF_GLASS_DELTA); }
vec3 bsdf_sheet(Bsdf bsdf) { return !NEEDS_TRANSMISSION || bsdf_is(bsdf, BSDF_SOLID) ? vec3(0.0) : bsdf.tint; }
float bsdf_glass(Bsdf bsdf) { return NEEDS_SOLID_GLASS ? bsdf.glass : 0.0; }
bool bsdf_has_specular(Bsdf bsdf) { return bsdf.specular_f90 > 0 || !is_black(bsdf.specular_f0); }
bool bsdf_has_coat(Bsdf bsdf) { return bsdf.coat_f90 > 0 || bsdf.coat_f0 > 0; }

vec3 schlick(vec3 f0, float f90, float cos_theta) { return f0 + (vec3(f90) - f0) * schlick_weight(cos_theta); }
float schlick(float f0, float f90, float cos_theta) { return f0 + (f90 - f0) * schlick_weight(cos_theta); }

/// Whether a direction leaves to the far side of both the shading and the geometric surface.
bool is_transmitted(vec3 wi, vec3 geometric_normal) { return wi.z < 0 && dot(wi, geometric_normal) < 0; }

/// Of the layered lobes: which there are, and of what kind.
void bsdf_classify_lobes(inout Bsdf bsdf) {
    const bool has_specular = bsdf_has_specular(bsdf);
    const bool has_sheet = !is_black(bsdf_sheet(bsdf)), has_glass = bsdf_glass(bsdf) > 0;
    const bool has_diffuse = !is_black(bsdf.diffuse);
    const bool specular_delta = bsdf_specular_delta(bsdf), glass_delta = bsdf_glass_delta(bsdf);
    const bool has_delta = ((has_specular || has_sheet) && specular_delta) || (has_glass && glass_delta);
    const bool transmits = (has_sheet && !specular_delta) || (has_glass && !glass_delta);
    const bool has_non_delta = has_diffuse || (has_specular && !specular_delta) || transmits;
    bsdf.flags &= ~(BSDF_HAS_NON_DELTA | BSDF_HAS_DELTA | BSDF_HAS_NON_DELTA_TRANSMISSION);
    bsdf.flags |= (has_delta ? BSDF_HAS_DELTA : 0u) | (has_non_delta ? BSDF_HAS_NON_DELTA : 0u) |
                  (transmits ? BSDF_HAS_NON_DELTA_TRANSMISSION : 0u);
}

Bsdf bsdf_layered(BsdfParameters p) {
    Bsdf bsdf = bsdf_nothing();
    bsdf.flags = BSDF_LAYERED;
    bsdf.geometric_normal = p.geometric_normal;
    if (p.roughness < DELTA_ROUGHNESS) bsdf.flags |= BSDF_SPECULAR_DELTA;
    bsdf.table_row = albedo_table_row(p.roughness);
    bsdf.alpha = sqr(p.roughness);
    const vec3 coat_f0 = min(normal_reflectance(p.ior) * p.specular_color, vec3(1.0)) * p.specular;
    bsdf.coat_f0 = max_component(coat_f0);
    // An index equal to its surroundings reflects nowhere; Schlick's curve would still rise to 1 at the horizon.
    bsdf.coat_f90 = p.ior == 1.0 ? 0.0 : p.specular;

    const bool solid = NEEDS_SOLID_GLASS && p.solid;
    const float transmission = NEEDS_TRANSMISSION ? p.transmission : 0.0;
    const float dielectric = 1.0 - p.metallic;
    const float coated = dielectric * (solid ? 1.0 - transmission : 1.0);
    bsdf.specular_f0 = coated * coat_f0 + p.metallic * p.base_color;
    bsdf.specular_f90 = coated * bsdf.coat_f90 + p.metallic;
    if (solid) {
        bsdf.flags |= BSDF_SOLID;
        bsdf.glass = dielectric * transmission;
        bsdf.tint = p.base_color;
        bsdf.glass_color = p.specular_color;
        bsdf.glass_specular = p.specular;
        bsdf.eta = p.eta;
    } else {
        bsdf.tint = dielectric * transmission * p.base_color;
    }
    const vec3 base = dielectric * (1.0 - transmission) * p.base_color;
    if (!is_black(base)) {
        const vec2 average = albedo_table_average(bsdf.table_row);
        const float passed = 1.0 - (bsdf.coat_f0 * average.x + bsdf.coat_f90 * average.y);
        // A coat that reflects all leaves nothing for the base; the quotient would be 0/0.
        if (passed > 2e-3) bsdf.diffuse = base / passed;
    }

    if (bsdf_is(bsdf, BSDF_SPECULAR_DELTA) || bsdf.alpha * abs(bsdf.eta - 1.0) < DELTA_REFRACTION)
        bsdf.flags |= BSDF_GLASS_DELTA;
    bsdf_classify_lobes(bsdf);
    return bsdf;
}

/// Whether there is any lobe that is not black.
bool bsdf_scatters(Bsdf bsdf) {
    return bsdf_is_layered(bsdf) ? bsdf_is(bsdf, BSDF_HAS_NON_DELTA | BSDF_HAS_DELTA)
                                 : bsdf_is(bsdf, BSDF_LAMBERT) && !is_black(bsdf.diffuse);
}
bool bsdf_is_lambert(Bsdf bsdf) { return bsdf_is(bsdf, BSDF_LAMBERT); }
bool bsdf_has_non_delta(Bsdf bsdf) { return bsdf_is(bsdf, BSDF_LAMBERT | BSDF_HAS_NON_DELTA); }
bool bsdf_has_delta(Bsdf bsdf) { return bsdf_is(bsdf, BSDF_HAS_DELTA); }
/// Whether light from the far side is scattered to the eye's by a lobe that is no delta.
bool bsdf_has_non_delta_transmission(Bsdf bsdf) {
    return NEEDS_TRANSMISSION && bsdf_is(bsdf, BSDF_HAS_NON_DELTA_TRANSMISSION);
}
/// Whether the diffuse lobe is all there is.
bool bsdf_is_diffuse(Bsdf bsdf) {
    if (!bsdf_is_layered(bsdf)) return bsdf_is(bsdf, BSDF_LAMBERT);
    return !bsdf_has_specular(bsdf) && is_black(bsdf_sheet(bsdf)) && bsdf_glass(bsdf) <= 0;
}
/// Index on the far side of a solid's interface over that on wo's side; 0 where nothing is refracted.
float bsdf_refraction_eta(Bsdf bsdf) { return bsdf_is_layered(bsdf) && bsdf_glass(bsdf) > 0 ? bsdf.eta : 0.0; }
/// The same lobes about another shading normal: in its frame the geometric normal is this.
Bsdf bsdf_with_geometric_normal(Bsdf bsdf, vec3 geometric_normal) {
    bsdf.geometric_normal = geometric_normal;
    return bsdf;
}

/// As looked at from the far side, in a frame in which the geometric normal on that side is this.
Bsdf bsdf_from_far_side(Bsdf bsdf, vec3 geometric_normal) {
    bsdf.geometric_normal = geometric_normal;
    if (bsdf.eta > 0) bsdf.eta = 1.0 / bsdf.eta;
    return bsdf;
}

/// The two parts of f = f_s + f_d, by which light paths are classified (methods.md, "photon_mapping"). Specular: delta
/// lobes, and GGX lobes with alpha below the threshold; rough: all others.
Bsdf bsdf_part(Bsdf bsdf, bool specular, float glossy_threshold) {
    if (!bsdf_is_layered(bsdf)) {
        if (specular) bsdf.flags = 0u;
        return bsdf;
    }
    const bool glossy = bsdf.alpha < glossy_threshold;
    // Only the lobes go; the coat's reflectance stays, as the diffuse lobe and the sheet lie under it.
    if ((bsdf_specular_delta(bsdf) || glossy) != specular) {
        bsdf.specular_f0 = vec3(0.0);
        if (!bsdf_is(bsdf, BSDF_SOLID)) bsdf.tint = vec3(0.0);
        bsdf.specular_f90 = 0.0;
    }
    if ((bsdf_glass_delta(bsdf) || glossy) != specular) bsdf.glass = 0.0;
    if (specular) bsdf.diffuse = vec3(0.0);
    bsdf_classify_lobes(bsdf);
    if (!bsdf_scatters(bsdf)) bsdf.flags = 0u;
    return bsdf;
}
Bsdf bsdf_specular_part(Bsdf bsdf, float glossy_threshold) { return bsdf_part(bsdf, true, glossy_threshold); }
Bsdf bsdf_rough_part(Bsdf bsdf, float glossy_threshold) { return bsdf_part(bsdf, false, glossy_threshold); }

float bsdf_coat_albedo(Bsdf bsdf, float cos_theta) {
    if (!bsdf_has_coat(bsdf)) return 0.0;
    const vec2 ab = albedo_table_directional(cos_theta, bsdf.table_row);
    return min(bsdf.coat_f0 * ab.x + bsdf.coat_f90 * ab.y, 1.0);  // the table may pass 1 by its margin
}

/// Fresnel reflectance of the solid's interface, scaled by KHR_materials_specular: the colour holds at normal incidence
/// and fades towards the horizon of the thinner medium, so that both sides agree. Total reflection stays total. What is
/// transmitted is 1 - the greatest channel.
vec3 bsdf_glass_reflectance(Bsdf bsdf, float cos_o, DielectricFresnel fresnel) {
    if (fresnel.cos_t <= 0) return vec3(1.0);
    const float weight = schlick_weight(min(cos_o, fresnel.cos_t));
    const vec3 color = bsdf.glass_color + (vec3(1.0) - bsdf.glass_color) * weight;
    return bsdf.glass_specular * min(fresnel.reflectance * color, vec3(1.0));
}

/// Probability of each lobe to be sampled from wo; they sum to 1, or are all 0 where nothing is scattered. And what the
/// coat reflects of wo, which they are made of.
struct LobeProbabilities {
    float diffuse;
    float specular;
    float sheet;
    float glass;
    float coat;
};

/// Lobes are chosen in proportion to the light they would scatter of a uniform field.
LobeProbabilities bsdf_lobe_probabilities(Bsdf bsdf, vec3 wo) {
    LobeProbabilities p;
    const vec3 sheet = bsdf_sheet(bsdf);
    vec2 ab = vec2(0.0);
    if (bsdf_has_specular(bsdf) || !is_black(sheet) || bsdf_has_coat(bsdf))
        ab = albedo_table_directional(wo.z, bsdf.table_row);
    p.coat = min(bsdf.coat_f0 * ab.x + bsdf.coat_f90 * ab.y, 1.0);
    p.diffuse = mean(bsdf.diffuse) * (1.0 - p.coat);
    p.specular = mean(bsdf.specular_f0) * ab.x + bsdf.specular_f90 * ab.y;
    p.sheet = mean(sheet) * max(ab.x + ab.y - p.coat, 0.0);
    p.glass = 0.0;
    const float glass = bsdf_glass(bsdf);
    if (glass > 0) {
        const vec3 reflected = bsdf_glass_reflectance(bsdf, wo.z, fresnel_dielectric(wo.z, bsdf.eta));
        p.glass = glass * (mean(reflected) + (1.0 - max_component(reflected)) * mean(bsdf.tint));
        // Rough facets reflect where the mean surface would not: never starve the lobe.
        p.glass = max(p.glass, 0.05 * glass);
    }
    const float sum = p.diffuse + p.specular + p.sheet + p.glass;
    if (!(sum > 0)) return LobeProbabilities(0.0, 0.0, 0.0, 0.0, 0.0);
    const float scale = 1.0 / sum;
    return LobeProbabilities(p.diffuse * scale, p.specular * scale, p.sheet * scale, p.glass * scale, p.coat);
}

/// Share of the samples of a facet of the solid's interface that are reflected.
float bsdf_reflection_probability(Bsdf bsdf, vec3 reflected) {
    const float r = mean(reflected), t = (1.0 - max_component(reflected)) * mean(bsdf.tint);
    return r + t > 0 ? r / (r + t) : 0.0;
}

BsdfValue bsdf_evaluate_refraction(Bsdf bsdf, vec3 wo, vec3 wi, uint mode, float probability) {
    // [Walter et al. 2007, Eq. 16]: the half-vector lies on the side of the thinner medium.
    vec3 h = wo + bsdf.eta * wi;
    const float length_sq = dot(h, h);
    if (!(length_sq > 0)) return NO_BSDF_VALUE;
    h *= (h.z < 0 ? -1.0 : 1.0) / sqrt(length_sq);
    const float cos_o = dot(wo, h), cos_i = dot(wi, h);
    if (cos_o <= 0 || cos_i >= 0) return NO_BSDF_VALUE;

    const DielectricFresnel fresnel = fresnel_dielectric(cos_o, bsdf.eta);
    if (fresnel.cos_t <= 0) return NO_BSDF_VALUE;
    const vec3 reflected = bsdf_glass_reflectance(bsdf, cos_o, fresnel);
    const Ggx ggx = Ggx(bsdf.alpha);
    // dh/dwi [Walter et al. 2007, Eq. 17]; masking and shadowing apart, as there: the two sides see different heights.
    const float jacobian = sqr(bsdf.eta) * -cos_i / sqr(cos_o + bsdf.eta * cos_i);
    const float visible = ggx_visible_pdf(ggx, wo, h) * jacobian;
    const float shadowing = ggx_g1_over_cos(ggx, wi) * -wi.z;
    const float compression = mode == TRANSPORT_RADIANCE ? 1.0 / sqr(bsdf.eta) : 1.0;
    return BsdfValue(
        bsdf_glass(bsdf) * (1.0 - max_component(reflected)) * bsdf.tint * (visible * shadowing * compression),
        probability * (1.0 - bsdf_reflection_probability(bsdf, reflected)) * visible);
}

BsdfValue bsdf_evaluate_layered(Bsdf bsdf, vec3 wo, vec3 wi, uint mode, LobeProbabilities p) {
    const bool specular_delta = bsdf_specular_delta(bsdf), glass_delta = bsdf_glass_delta(bsdf);
    if (is_transmitted(wi, bsdf.geometric_normal)) {
        if (NEEDS_SOLID_GLASS && p.glass > 0 && !glass_delta)
            return bsdf_evaluate_refraction(bsdf, wo, wi, mode, p.glass);
        if (NEEDS_TRANSMISSION && p.sheet > 0 && !specular_delta) {
            const Ggx ggx = Ggx(bsdf.alpha);
            const vec3 mirrored = vec3(wi.x, wi.y, -wi.z);
            const vec3 h = normalize(wo + mirrored);
            const float passed = 1.0 - schlick(bsdf.coat_f0, bsdf.coat_f90, dot(wo, h));
            const float lobe = 0.25 * ggx_d(ggx, h) * ggx_g2_over_cosines(ggx, wo, mirrored) * mirrored.z;
            return BsdfValue(bsdf_sheet(bsdf) * passed * lobe, p.sheet * ggx_reflection_pdf(ggx, wo, h));
        }
        return NO_BSDF_VALUE;
    }
    if (wi.z <= 0 || dot(wi, bsdf.geometric_normal) <= 0) return NO_BSDF_VALUE;

    BsdfValue value = NO_BSDF_VALUE;
    if (p.diffuse > 0) {
        // [Kelemen and Szirmay-Kalos 2001, Eq. 4]
        const float coupling = (1.0 - p.coat) * (1.0 - bsdf_coat_albedo(bsdf, wi.z));
        value.f_cos = bsdf.diffuse * coupling * (wi.z * INV_PI);
        value.pdf_sa = p.diffuse * wi.z * INV_PI;
    }
    const bool specular = p.specular > 0 && !specular_delta, glass = p.glass > 0 && !glass_delta;
    if (specular || glass) {
        const Ggx ggx = Ggx(bsdf.alpha);
        const vec3 h = normalize(wo + wi);
        const float cos_h = dot(wo, h), d = ggx_d(ggx, h);
        const float lobe = 0.25 * d * ggx_g2_over_cosines(ggx, wo, wi) * wi.z;
        const float pdf = 0.25 * d * ggx_g1_over_cos(ggx, wo);
        if (specular) {
            value.f_cos += schlick(bsdf.specular_f0, bsdf.specular_f90, cos_h) * lobe;
            value.pdf_sa += p.specular * pdf;
        }
        if (NEEDS_SOLID_GLASS && glass) {
            const vec3 reflected = bsdf_glass_reflectance(bsdf, cos_h, fresnel_dielectric(cos_h, bsdf.eta));
            value.f_cos += bsdf_glass(bsdf) * reflected * lobe;
            value.pdf_sa += p.glass * bsdf_reflection_probability(bsdf, reflected) * pdf;
        }
    }
    return value;
}

BsdfValue bsdf_evaluate(Bsdf bsdf, vec3 wo, vec3 wi, uint mode) {
    if (bsdf_is_lambert(bsdf)) {
        if (wo.z <= 0 || wi.z <= 0 || dot(wi, bsdf.geometric_normal) <= 0) return NO_BSDF_VALUE;
        return BsdfValue(bsdf.diffuse * (wi.z * INV_PI), wi.z * INV_PI);
    }
    if (!bsdf_is_layered(bsdf) || wo.z <= 0 || !bsdf_has_non_delta(bsdf)) return NO_BSDF_VALUE;
    return bsdf_evaluate_layered(bsdf, wo, wi, mode, bsdf_lobe_probabilities(bsdf, wo));
}
BsdfValue bsdf_evaluate(Bsdf bsdf, vec3 wo, vec3 wi) { return bsdf_evaluate(bsdf, wo, wi, TRANSPORT_RADIANCE); }
vec3 bsdf_f_cos(Bsdf bsdf, vec3 wo, vec3 wi, uint mode) { return bsdf_evaluate(bsdf, wo, wi, mode).f_cos; }
vec3 bsdf_f_cos(Bsdf bsdf, vec3 wo, vec3 wi) { return bsdf_f_cos(bsdf, wo, wi, TRANSPORT_RADIANCE); }
float bsdf_pdf_sa(Bsdf bsdf, vec3 wo, vec3 wi) { return bsdf_evaluate(bsdf, wo, wi).pdf_sa; }

/// A direction by the solid's interface. Delta: complete. Rough: the direction and its kind, to be evaluated; wi.z = 0
/// when there is none.
BsdfSample bsdf_sample_glass(Bsdf bsdf, vec3 wo, float u_choice, vec2 u, float probability, uint mode) {
    BsdfSample s = NO_BSDF_SAMPLE;
    const bool glass_delta = bsdf_glass_delta(bsdf);
    const vec3 h = glass_delta ? vec3(0.0, 0.0, 1.0) : ggx_sample_visible(Ggx(bsdf.alpha), wo, u);
    const float cos_o = dot(wo, h);
    const DielectricFresnel fresnel = fresnel_dielectric(cos_o, bsdf.eta);
    const vec3 reflected = bsdf_glass_reflectance(bsdf, cos_o, fresnel);
    const float reflection = bsdf_reflection_probability(bsdf, reflected);
    s.transmission = s.refraction = u_choice >= reflection;
    if (s.transmission) {
        // Equal indices: straight through, without rounding.
        s.wi = bsdf.eta == 1.0 ? -wo : refract_direction(wo, h, cos_o, fresnel.cos_t, bsdf.eta);
        s.eta = bsdf.eta;
    } else {
        s.wi = reflect_direction(wo, h);
    }
    const bool reachable = s.transmission ? fresnel.cos_t > 0 && is_transmitted(s.wi, bsdf.geometric_normal)
                                          : s.wi.z > 0 && dot(s.wi, bsdf.geometric_normal) > 0;
    if (!reachable) {
        s.wi = vec3(1.0, 0.0, 0.0);
        return s;
    }
    if (glass_delta) {
        s.delta = true;
        const float compression = mode == TRANSPORT_RADIANCE ? 1.0 / sqr(bsdf.eta) : 1.0;
        const float chosen = s.transmission ? 1.0 - reflection : reflection;
        s.pdf_sa = probability * chosen;
        s.weight = bsdf_glass(bsdf) / s.pdf_sa *
                   (s.transmission ? (1.0 - max_component(reflected)) * compression * bsdf.tint : reflected);
    }
    return s;
}

BsdfSample bsdf_sample_layered(Bsdf bsdf, vec3 wo, float u_lobe, vec2 u, uint mode) {
    BsdfSample s = NO_BSDF_SAMPLE;
    if (wo.z <= 0) return s;
    const LobeProbabilities p = bsdf_lobe_probabilities(bsdf, wo);

    if (u_lobe < p.diffuse) {
        s.wi = sample_cosine_hemisphere(u);
    } else if (u_lobe < p.diffuse + p.specular + p.sheet) {
        const bool specular_delta = bsdf_specular_delta(bsdf);
        s.transmission = NEEDS_TRANSMISSION && u_lobe >= p.diffuse + p.specular;
        const vec3 h = specular_delta ? vec3(0.0, 0.0, 1.0) : ggx_sample_visible(Ggx(bsdf.alpha), wo, u);
        s.wi = reflect_direction(wo, h);
        if (s.wi.z <= 0) return s;
        if (s.transmission) s.wi.z = -s.wi.z;
        if (specular_delta) {
            const float side = dot(s.wi, bsdf.geometric_normal);
            if (s.transmission ? side >= 0 : side <= 0) return s;
            const float passed = 1.0 - schlick(bsdf.coat_f0, bsdf.coat_f90, wo.z);
            s.delta = true;
            s.pdf_sa = s.transmission ? p.sheet : p.specular;
            s.weight =
                (s.transmission ? bsdf_sheet(bsdf) * passed : schlick(bsdf.specular_f0, bsdf.specular_f90, wo.z)) /
                s.pdf_sa;
            return s;
        }
    } else if (NEEDS_SOLID_GLASS && p.glass > 0) {
        // What is left of the number, kept in [0, 1) against rounding: a facet without reflection must transmit.
        const float u_choice = clamp((u_lobe - (1.0 - p.glass)) / p.glass, 0.0, BELOW_ONE);
        s = bsdf_sample_glass(bsdf, wo, u_choice, u, p.glass, mode);
        if (s.delta || s.wi.z == 0) return s;
    } else {
        return s;
    }
    const BsdfValue value = bsdf_evaluate_layered(bsdf, wo, s.wi, mode, p);
    if (!(value.pdf_sa > 0)) return s;
    s.pdf_sa = value.pdf_sa;
    s.weight = value.f_cos / value.pdf_sa;
    return s;
}

/// Draws wi from three uniform numbers in [0, 1): one chooses the lobe, two its direction.
BsdfSample bsdf_sample(Bsdf bsdf, vec3 wo, float u_lobe, vec2 u, uint mode) {
    if (bsdf_is_lambert(bsdf)) {
        BsdfSample s = NO_BSDF_SAMPLE;
        s.wi = sample_cosine_hemisphere(u);
        if (wo.z <= 0 || dot(s.wi, bsdf.geometric_normal) <= 0) return s;
        s.weight = bsdf.diffuse;
        s.pdf_sa = s.wi.z * INV_PI;
        return s;
    }
    if (!bsdf_is_layered(bsdf)) return NO_BSDF_SAMPLE;
    return bsdf_sample_layered(bsdf, wo, u_lobe, u, mode);
}
BsdfSample bsdf_sample(Bsdf bsdf, vec3 wo, float u_lobe, vec2 u) {
    return bsdf_sample(bsdf, wo, u_lobe, u, TRANSPORT_RADIANCE);
}

/// Share of uniform illumination of the eye's side that is scattered, transmission included; for the albedo layer.
vec3 bsdf_albedo(Bsdf bsdf) {
    if (!bsdf_is_layered(bsdf)) return bsdf_is_lambert(bsdf) ? bsdf.diffuse : vec3(0.0);
    const vec2 average = albedo_table_average(bsdf.table_row);
    const float coat = bsdf.coat_f0 * average.x + bsdf.coat_f90 * average.y;
    vec3 sum = bsdf.diffuse * sqr(1.0 - coat) + bsdf.specular_f0 * average.x + bsdf.specular_f90 * average.y +
               bsdf_sheet(bsdf) * (average.x + average.y - coat);
    const float glass = bsdf_glass(bsdf);
    if (glass > 0) {
        // Mean of Schlick's curve over the hemisphere: F0 + (1 - F0)/21. Near enough for a picture of reflectance.
        const float f0 = normal_reflectance(bsdf.eta);
        const vec3 reflected = bsdf.glass_specular * min(bsdf.glass_color * (f0 + (1.0 - f0) / 21.0), vec3(1.0));
        sum += glass * (reflected + (1.0 - max_component(reflected)) * bsdf.tint);
    }
    return sum;
}

#endif

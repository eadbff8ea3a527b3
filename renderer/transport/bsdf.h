#pragma once
// Scattering at a surface: its material (conventions.md, "Materials") as a small plain value, made anew at each hit.
//
// Directions are local to the shading frame (+z is the shading normal, on the eye's side), unit, and leave the surface:
// `wo` towards the eye, `wi` towards the light. Lobes:
//   diffuse       Lambert, under the dielectric coat. glTF's plain mix of coat and base reflects more than it gets at
//                 grazing angles (conventions.md, "Materials"); here the base gets what the coat lets in and out, after
//                 [Kelemen and Szirmay-Kalos 2001]:
//                   f_d = rho / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_avg),  E the coat's directional albedo,
//                 which is reciprocal and whose reflectance is rho (1 - E(wo)). Of a coat that reflects colours E is
//                 that of its greatest channel, for all: the base does not take on the coat's complement.
//   specular      GGX with height-correlated Smith shadowing [Heitz 2014] and Schlick's Fresnel, single scattering. The
//                 coat and metal share the distribution, so they are one lobe with F0 and F90 mixed by `metallic`.
//   glass         a solid's interface: exact Fresnel, reflection and refraction [Walter et al. 2007].
//   thin sheet    what the coat does not reflect goes straight through (rough: scattered about straight through, with
//                 the specular lobe mirrored), tinted by the base colour. Of a coloured coat or interface, here and
//                 in glass, what passes is 1 - the greatest channel of F (KHR_materials_specular).
// Lobes with a roughness below DELTA_ROUGHNESS are delta: only sample() finds them.
// Every lobe reflects only to the geometric eye side, and transmits only to the other.
//
// [Kelemen and Szirmay-Kalos 2001] A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling.
// [Walter et al. 2007] Microfacet Models for Refraction through Rough Surfaces. EGSR.
// [Heitz 2014] Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs. JCGT 3(2).
// [Heitz 2018] Sampling the GGX Distribution of Visible Normals. JCGT 7(4).

#include "renderer/core/rgb.h"
#include "renderer/scene/delta_shared.h"
#include "renderer/transport/sampling.h"
#include "renderer/transport/surface.h"

namespace photond {

/// What flows from light to eye while the path is built: radiance (paths that start at the eye) is compressed by
/// refraction, importance (paths that start at a light) is not. [Veach 1997, sec. 5.2]
enum class TransportMode : uint8_t { Radiance, Importance };

/// f(wo, wi) |cos(wi)| [sr^-1], and the density [sr^-1] with which sample(wo) finds wi. Delta lobes are not in either.
struct BsdfValue {
    Rgb f_cos{0};
    float pdf_sa = 0;
};

/// One sampled direction. A sample with pdf_sa = 0 is to be dropped (the path ends).
struct BsdfSample {
    vec3 wi{0, 0, 1};
    Rgb weight{0};     // f |cos| / pdf; of a delta lobe its reflectance over its probability
    float pdf_sa = 0;  // what evaluate() says; of a delta lobe the probability of having chosen it, no density
    bool delta = false;
    bool transmission = false;  // wi is on the other side
    bool refraction = false;    // ... and inside (or outside) of a solid: the medium changed
    float eta = 1;              // refraction: index on wi's side over that on wo's side; else 1

    bool valid() const { return pdf_sa > 0; }
};

class Bsdf {
public:
    /// Scatters nothing (unlit surfaces).
    Bsdf() = default;

    /// `geometric_normal` local; `reflectance` in [0, 1].
    static Bsdf lambert(const vec3& geometric_normal, const Rgb& reflectance) {
        Bsdf bsdf;
        bsdf.kind_ = Kind::Lambert;
        bsdf.geometric_normal_ = geometric_normal;
        bsdf.diffuse_ = reflectance;
        return bsdf;
    }

    /// Everything that the layered lobes are made of; all factors in [0, 1] unless said.
    struct Parameters {
        vec3 geometric_normal{0, 0, 1};  // local
        Rgb base_color{1};
        float metallic = 0;
        float roughness = 1;  // alpha is its square
        float ior = 1.5f;     // of the coat against air; >= 1, or 0 for F0 = 1
        float specular = 1;
        Rgb specular_color{1};  // >= 0, may exceed 1
        float transmission = 0;
        bool solid = false;  // transmission is by refraction, else that of a thin sheet
        float eta = 1.5f;    // solid: index on the far side over that on the eye's side; 0 reflects all
    };
    static Bsdf layered(const Parameters& parameters);

    BsdfValue evaluate(const vec3& wo, const vec3& wi, TransportMode mode = TransportMode::Radiance) const {
        if (kind_ == Kind::Lambert) {
            if (wo.z <= 0 || wi.z <= 0 || glm::dot(wi, geometric_normal_) <= 0) return {};
            return {diffuse_ * (wi.z * kInvPi), wi.z * kInvPi};
        }
        return kind_ == Kind::Nothing ? BsdfValue{} : evaluate_layered(wo, wi, mode);
    }
    Rgb f_cos(const vec3& wo, const vec3& wi, TransportMode mode = TransportMode::Radiance) const {
        return evaluate(wo, wi, mode).f_cos;
    }
    float pdf_sa(const vec3& wo, const vec3& wi) const { return evaluate(wo, wi).pdf_sa; }

    /// Draws wi from three uniform numbers in [0, 1): one chooses the lobe, two its direction.
    BsdfSample sample(const vec3& wo, float u_lobe, vec2 u, TransportMode mode = TransportMode::Radiance) const {
        if (kind_ == Kind::Lambert) {
            BsdfSample s;
            s.wi = sample_cosine_hemisphere(u);
            if (wo.z <= 0 || glm::dot(s.wi, geometric_normal_) <= 0) return s;
            s.weight = diffuse_;
            s.pdf_sa = s.wi.z * kInvPi;
            return s;
        }
        return kind_ == Kind::Nothing ? BsdfSample{} : sample_layered(wo, u_lobe, u, mode);
    }

    /// The two parts of f = f_s + f_d, by which light paths are classified (methods.md, "photon_mapping"). Specular:
    /// delta lobes, and GGX lobes with alpha below the threshold; rough: all others. Each part is a BSDF of its own,
    /// sampled by its own lobes alone; what the coat lets through to the diffuse lobe or the sheet is that of the
    /// whole.
    Bsdf specular_part(float glossy_threshold) const;
    Bsdf rough_part(float glossy_threshold) const;

    /// Whether there is any lobe that is not black.
    bool scatters() const {
        return kind_ == Kind::Lambert ? !is_black(diffuse_) : kind_ == Kind::Layered && (has_non_delta_ || has_delta_);
    }
    bool is_lambert() const { return kind_ == Kind::Lambert; }
    bool has_non_delta() const { return kind_ == Kind::Lambert || has_non_delta_; }
    bool has_delta() const { return has_delta_; }
    /// Whether light from the far side is scattered to the eye's by a lobe that is no delta.
    bool has_non_delta_transmission() const { return has_non_delta_transmission_; }

    /// Whether the diffuse lobe is all there is.
    bool is_diffuse() const;
    /// Index on the far side of a solid's interface over that on wo's side; 0 where nothing is refracted.
    float refraction_eta() const { return kind_ == Kind::Layered && layers_.glass > 0 ? layers_.eta : 0.0f; }
    /// The same lobes about another shading normal: in its frame the geometric normal is this.
    Bsdf with_geometric_normal(const vec3& geometric_normal) const;
    /// As looked at from the far side, in a frame in which the geometric normal on that side is this.
    Bsdf from_far_side(const vec3& geometric_normal) const;

    /// Share of uniform illumination of the eye's side that is scattered, transmission included; for the albedo layer.
    Rgb albedo() const;

private:
    friend class BsdfEvaluator;
    enum class Kind : uint8_t { Nothing, Lambert, Layered };

    /// Probability of each lobe to be sampled from wo; they sum to 1, or are all 0 where nothing is scattered. And what
    /// the coat reflects of wo, which they are made of.
    struct LobeProbabilities {
        float diffuse = 0;
        float specular = 0;
        float sheet = 0;
        float glass = 0;
        float coat = 0;
    };

    /// Layered lobes; weights by `metallic` and `transmission` are in the colours.
    struct Layers {
        float alpha = 1;
        float table_row = 0;  // AlbedoTable's, of the roughness
        Rgb specular_f0{0};
        float specular_f90 = 0;
        float coat_f0 =
            0;  // of the dielectric alone, its greatest channel: what the diffuse lobe and the sheet lie under
        float coat_f90 = 0;
        Rgb sheet{0};              // tint of the thin sheet
        float glass = 0;           // share of the solid's interface
        Rgb glass_tint{0};         // of what is refracted
        Rgb glass_color{1};        // specular_color of the interface; white towards grazing angles
        float glass_specular = 1;  // share of the interface that reflects at all
        float eta = 1;
        bool specular_delta = false;  // and the sheet's
        bool glass_delta = false;
    };

    float coat_albedo(float cos_theta) const;
    Rgb glass_reflectance(float cos_o, float fresnel, float cos_t) const;
    LobeProbabilities lobe_probabilities(const vec3& wo) const;
    BsdfValue evaluate_layered(const vec3& wo, const vec3& wi, TransportMode mode) const;
    BsdfValue evaluate_layered(const vec3& wo, const vec3& wi, TransportMode mode, const LobeProbabilities& p) const;
    BsdfValue evaluate_refraction(const vec3& wo, const vec3& wi, TransportMode mode, float probability) const;
    BsdfSample sample_layered(const vec3& wo, float u_lobe, vec2 u, TransportMode mode) const;
    BsdfSample sample_glass(const vec3& wo, float u_choice, vec2 u, float probability, TransportMode mode) const;
    float reflection_probability(const Rgb& reflected) const;
    Bsdf part(bool specular, float glossy_threshold) const;
    void classify_lobes();

    Kind kind_ = Kind::Nothing;
    bool has_non_delta_ = false;  // of layered
    bool has_delta_ = false;
    bool has_non_delta_transmission_ = false;
    vec3 geometric_normal_{0, 0, 1};
    Rgb diffuse_{0};  // layered: over 1 - E_avg
    Layers layers_;
};

/// The scattering at a hit. `outside_ior`: index of the medium on the outer side of a solid's surface (1 unless it lies
/// in another solid), whichever side is looked at.
Bsdf make_bsdf(const Scene& scene, const ShadingPoint& point, float outside_ior = 1.0f);

}  // namespace photond

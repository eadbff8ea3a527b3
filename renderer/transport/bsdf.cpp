#include "renderer/transport/bsdf.h"

#include <cassert>

#include "renderer/scene/surface_color.h"
#include "renderer/transport/bsdf_albedo_table.h"
#include "renderer/transport/fresnel.h"
#include "renderer/transport/microfacet.h"

namespace photond {

namespace {

Rgb schlick(const Rgb& f0, float f90, float cos_theta) { return f0 + (Rgb(f90) - f0) * schlick_weight(cos_theta); }
float schlick(float f0, float f90, float cos_theta) { return f0 + (f90 - f0) * schlick_weight(cos_theta); }

/// Whether a direction leaves to the far side of both the shading and the geometric surface.
bool is_transmitted(const vec3& wi, const vec3& geometric_normal) {
    return wi.z < 0 && glm::dot(wi, geometric_normal) < 0;
}

}  // namespace

Bsdf Bsdf::layered(const Parameters& p) {
    assert(p.eta >= 0 && std::isfinite(p.eta));
    Bsdf bsdf;
    bsdf.kind_ = Kind::Layered;
    bsdf.geometric_normal_ = p.geometric_normal;
    Layers& layers = bsdf.layers_;
    layers.specular_delta = p.roughness < DELTA_ROUGHNESS;
    layers.table_row = AlbedoTable::row(p.roughness);
    layers.alpha = sqr(p.roughness);
    const Rgb coat_f0 = glm::min(normal_reflectance(p.ior) * p.specular_color, Rgb(1)) * p.specular;
    layers.coat_f0 = max_component(coat_f0);
    // An index equal to its surroundings reflects nowhere; Schlick's curve would still rise to 1 at the horizon.
    layers.coat_f90 = p.ior == 1.0f ? 0.0f : p.specular;

    const float dielectric = 1.0f - p.metallic;
    const float coated = dielectric * (p.solid ? 1.0f - p.transmission : 1.0f);
    layers.specular_f0 = coated * coat_f0 + p.metallic * p.base_color;
    layers.specular_f90 = coated * layers.coat_f90 + p.metallic;
    if (p.solid) {
        layers.glass = dielectric * p.transmission;
        layers.glass_tint = p.base_color;
        layers.glass_color = p.specular_color;
        layers.glass_specular = p.specular;
        layers.eta = p.eta;
    } else {
        layers.sheet = dielectric * p.transmission * p.base_color;
    }
    const Rgb base = dielectric * (1.0f - p.transmission) * p.base_color;
    if (!is_black(base)) {
        const vec2 average = AlbedoTable::get().average(layers.table_row);
        const float passed = 1.0f - (layers.coat_f0 * average.x + layers.coat_f90 * average.y);
        // A coat that reflects all leaves nothing for the base; the quotient would be 0/0.
        if (passed > 2e-3f) bsdf.diffuse_ = base / passed;
    }

    layers.glass_delta = layers.specular_delta || layers.alpha * std::fabs(layers.eta - 1.0f) < DELTA_REFRACTION;
    bsdf.classify_lobes();
    return bsdf;
}

/// Of the layered lobes: which there are, and of what kind.
void Bsdf::classify_lobes() {
    const bool has_specular = layers_.specular_f90 > 0 || !is_black(layers_.specular_f0);
    const bool has_sheet = !is_black(layers_.sheet), has_glass = layers_.glass > 0;
    const bool has_diffuse = !is_black(diffuse_);
    has_delta_ = ((has_specular || has_sheet) && layers_.specular_delta) || (has_glass && layers_.glass_delta);
    has_non_delta_transmission_ = (has_sheet && !layers_.specular_delta) || (has_glass && !layers_.glass_delta);
    has_non_delta_ = has_diffuse || (has_specular && !layers_.specular_delta) || has_non_delta_transmission_;
}

Bsdf Bsdf::part(bool specular, float glossy_threshold) const {
    if (kind_ == Kind::Nothing) return {};
    if (kind_ == Kind::Lambert) return specular ? Bsdf() : *this;
    const bool glossy = layers_.alpha < glossy_threshold;
    Bsdf part = *this;
    // Only the lobes go; the coat's reflectance stays, as the diffuse lobe and the sheet lie under it.
    if ((layers_.specular_delta || glossy) != specular) {
        part.layers_.specular_f0 = part.layers_.sheet = Rgb(0);
        part.layers_.specular_f90 = 0;
    }
    if ((layers_.glass_delta || glossy) != specular) part.layers_.glass = 0;
    if (specular) part.diffuse_ = Rgb(0);
    part.classify_lobes();
    return part.scatters() ? part : Bsdf();
}

Bsdf Bsdf::specular_part(float glossy_threshold) const { return part(true, glossy_threshold); }

Bsdf Bsdf::rough_part(float glossy_threshold) const { return part(false, glossy_threshold); }

bool Bsdf::is_diffuse() const {
    if (kind_ != Kind::Layered) return kind_ == Kind::Lambert;
    return layers_.specular_f90 <= 0 && is_black(layers_.specular_f0) && is_black(layers_.sheet) && layers_.glass <= 0;
}

Bsdf Bsdf::with_geometric_normal(const vec3& geometric_normal) const {
    Bsdf turned = *this;
    turned.geometric_normal_ = geometric_normal;
    return turned;
}

Bsdf Bsdf::from_far_side(const vec3& geometric_normal) const {
    Bsdf turned = with_geometric_normal(geometric_normal);
    if (layers_.eta > 0) turned.layers_.eta = 1.0f / layers_.eta;
    return turned;
}

float Bsdf::coat_albedo(float cos_theta) const {
    if (layers_.coat_f90 <= 0 && layers_.coat_f0 <= 0) return 0;
    const vec2 ab = AlbedoTable::get().directional(cos_theta, layers_.table_row);
    return std::min(layers_.coat_f0 * ab.x + layers_.coat_f90 * ab.y, 1.0f);  // the table may pass 1 by its margin
}

/// Fresnel reflectance of the solid's interface, scaled by KHR_materials_specular: the colour holds at normal incidence
/// and fades towards the horizon of the thinner medium, so that both sides agree. Total reflection stays total. What is
/// transmitted is 1 - the greatest channel.
Rgb Bsdf::glass_reflectance(float cos_o, float fresnel, float cos_t) const {
    if (cos_t <= 0) return Rgb(1);
    const float weight = schlick_weight(std::min(cos_o, cos_t));
    const Rgb color = layers_.glass_color + (Rgb(1) - layers_.glass_color) * weight;
    return layers_.glass_specular * glm::min(fresnel * color, Rgb(1));
}

/// Lobes are chosen in proportion to the light they would scatter of a uniform field.
Bsdf::LobeProbabilities Bsdf::lobe_probabilities(const vec3& wo) const {
    LobeProbabilities p;
    vec2 ab(0);
    const bool needs_table = layers_.specular_f90 > 0 || !is_black(layers_.specular_f0) || !is_black(layers_.sheet) ||
                             layers_.coat_f90 > 0 || layers_.coat_f0 > 0;
    if (needs_table) ab = AlbedoTable::get().directional(wo.z, layers_.table_row);
    const float coat = std::min(layers_.coat_f0 * ab.x + layers_.coat_f90 * ab.y, 1.0f);
    p.diffuse = mean(diffuse_) * (1.0f - coat);
    p.specular = mean(layers_.specular_f0) * ab.x + layers_.specular_f90 * ab.y;
    p.sheet = mean(layers_.sheet) * std::max(ab.x + ab.y - coat, 0.0f);
    if (layers_.glass > 0) {
        const DielectricFresnel fresnel = fresnel_dielectric(wo.z, layers_.eta);
        const Rgb reflected = glass_reflectance(wo.z, fresnel.reflectance, fresnel.cos_t);
        p.glass = layers_.glass * (mean(reflected) + (1.0f - max_component(reflected)) * mean(layers_.glass_tint));
        // Rough facets reflect where the mean surface would not: never starve the lobe.
        p.glass = std::max(p.glass, 0.05f * layers_.glass);
    }
    const float sum = p.diffuse + p.specular + p.sheet + p.glass;
    if (!(sum > 0)) return {};
    const float scale = 1.0f / sum;
    return {p.diffuse * scale, p.specular * scale, p.sheet * scale, p.glass * scale, coat};
}

BsdfValue Bsdf::evaluate_layered(const vec3& wo, const vec3& wi, TransportMode mode) const {
    if (wo.z <= 0 || !has_non_delta_) return {};
    return evaluate_layered(wo, wi, mode, lobe_probabilities(wo));
}

BsdfValue Bsdf::evaluate_layered(const vec3& wo, const vec3& wi, TransportMode mode, const LobeProbabilities& p) const {
    if (is_transmitted(wi, geometric_normal_)) {
        if (p.glass > 0 && !layers_.glass_delta) return evaluate_refraction(wo, wi, mode, p.glass);
        if (p.sheet > 0 && !layers_.specular_delta) {
            const Ggx ggx{layers_.alpha};
            const vec3 mirrored(wi.x, wi.y, -wi.z);
            const vec3 h = glm::normalize(wo + mirrored);
            const float passed = 1.0f - schlick(layers_.coat_f0, layers_.coat_f90, glm::dot(wo, h));
            const float lobe = 0.25f * ggx.d(h) * ggx.g2_over_cosines(wo, mirrored) * mirrored.z;
            return {layers_.sheet * passed * lobe, p.sheet * ggx.reflection_pdf(wo, h)};
        }
        return {};
    }
    if (wi.z <= 0 || glm::dot(wi, geometric_normal_) <= 0) return {};

    BsdfValue value;
    if (p.diffuse > 0) {
        // [Kelemen and Szirmay-Kalos 2001, Eq. 4]
        const float coupling = (1.0f - p.coat) * (1.0f - coat_albedo(wi.z));
        value.f_cos = diffuse_ * coupling * (wi.z * kInvPi);
        value.pdf_sa = p.diffuse * wi.z * kInvPi;
    }
    const bool specular = p.specular > 0 && !layers_.specular_delta, glass = p.glass > 0 && !layers_.glass_delta;
    if (specular || glass) {
        const Ggx ggx{layers_.alpha};
        const vec3 h = glm::normalize(wo + wi);
        const float cos_h = glm::dot(wo, h), d = ggx.d(h);
        const float lobe = 0.25f * d * ggx.g2_over_cosines(wo, wi) * wi.z;
        const float pdf = 0.25f * d * ggx.g1_over_cos(wo);
        if (specular) {
            value.f_cos += schlick(layers_.specular_f0, layers_.specular_f90, cos_h) * lobe;
            value.pdf_sa += p.specular * pdf;
        }
        if (glass) {
            const DielectricFresnel fresnel = fresnel_dielectric(cos_h, layers_.eta);
            const Rgb reflected = glass_reflectance(cos_h, fresnel.reflectance, fresnel.cos_t);
            value.f_cos += layers_.glass * reflected * lobe;
            value.pdf_sa += p.glass * reflection_probability(reflected) * pdf;
        }
    }
    return value;
}

/// Share of the samples of a facet of the solid's interface that are reflected.
float Bsdf::reflection_probability(const Rgb& reflected) const {
    const float r = mean(reflected), t = (1.0f - max_component(reflected)) * mean(layers_.glass_tint);
    return r + t > 0 ? r / (r + t) : 0.0f;
}

BsdfValue Bsdf::evaluate_refraction(const vec3& wo, const vec3& wi, TransportMode mode, float probability) const {
    // [Walter et al. 2007, Eq. 16]: the half-vector lies on the side of the thinner medium.
    vec3 h = wo + layers_.eta * wi;
    const float length_sq = glm::dot(h, h);
    if (!(length_sq > 0)) return {};
    h *= (h.z < 0 ? -1.0f : 1.0f) / std::sqrt(length_sq);
    const float cos_o = glm::dot(wo, h), cos_i = glm::dot(wi, h);
    if (cos_o <= 0 || cos_i >= 0) return {};

    const DielectricFresnel fresnel = fresnel_dielectric(cos_o, layers_.eta);
    if (fresnel.cos_t <= 0) return {};
    const Rgb reflected = glass_reflectance(cos_o, fresnel.reflectance, fresnel.cos_t);
    const Ggx ggx{layers_.alpha};
    // dh/dwi [Walter et al. 2007, Eq. 17]; masking and shadowing apart, as there: the two sides see different heights.
    const float jacobian = sqr(layers_.eta) * -cos_i / sqr(cos_o + layers_.eta * cos_i);
    const float visible = ggx.visible_pdf(wo, h) * jacobian;
    const float shadowing = ggx.g1_over_cos(wi) * -wi.z;
    const float compression = mode == TransportMode::Radiance ? 1.0f / sqr(layers_.eta) : 1.0f;
    return {
        layers_.glass * (1.0f - max_component(reflected)) * layers_.glass_tint * (visible * shadowing * compression),
        probability * (1.0f - reflection_probability(reflected)) * visible};
}

BsdfSample Bsdf::sample_layered(const vec3& wo, float u_lobe, vec2 u, TransportMode mode) const {
    BsdfSample s;
    if (wo.z <= 0) return s;
    const LobeProbabilities p = lobe_probabilities(wo);

    if (u_lobe < p.diffuse) {
        s.wi = sample_cosine_hemisphere(u);
    } else if (u_lobe < p.diffuse + p.specular + p.sheet) {
        s.transmission = u_lobe >= p.diffuse + p.specular;
        const vec3 h = layers_.specular_delta ? vec3(0, 0, 1) : Ggx{layers_.alpha}.sample_visible(wo, u);
        s.wi = reflect_direction(wo, h);
        if (s.wi.z <= 0) return s;
        if (s.transmission) s.wi.z = -s.wi.z;
        if (layers_.specular_delta) {
            const float side = glm::dot(s.wi, geometric_normal_);
            if (s.transmission ? side >= 0 : side <= 0) return s;
            const float passed = 1.0f - schlick(layers_.coat_f0, layers_.coat_f90, wo.z);
            s.delta = true;
            s.pdf_sa = s.transmission ? p.sheet : p.specular;
            s.weight =
                (s.transmission ? layers_.sheet * passed : schlick(layers_.specular_f0, layers_.specular_f90, wo.z)) /
                s.pdf_sa;
            return s;
        }
    } else if (p.glass > 0) {
        // What is left of the number, kept in [0, 1) against rounding: a facet without reflection must transmit.
        const float u_choice = std::clamp((u_lobe - (1.0f - p.glass)) / p.glass, 0.0f, 0x1.fffffep-1f);
        s = sample_glass(wo, u_choice, u, p.glass, mode);
        if (s.delta || s.wi.z == 0) return s;
    } else {
        return s;
    }
    const BsdfValue value = evaluate_layered(wo, s.wi, mode, p);
    if (!(value.pdf_sa > 0)) return s;
    s.pdf_sa = value.pdf_sa;
    s.weight = value.f_cos / value.pdf_sa;
    return s;
}

/// A direction by the solid's interface. Delta: complete. Rough: the direction and its kind, to be evaluated; wi.z = 0
/// when there is none.
BsdfSample Bsdf::sample_glass(const vec3& wo, float u_choice, vec2 u, float probability, TransportMode mode) const {
    BsdfSample s;
    const vec3 h = layers_.glass_delta ? vec3(0, 0, 1) : Ggx{layers_.alpha}.sample_visible(wo, u);
    const float cos_o = glm::dot(wo, h);
    const DielectricFresnel fresnel = fresnel_dielectric(cos_o, layers_.eta);
    const Rgb reflected = glass_reflectance(cos_o, fresnel.reflectance, fresnel.cos_t);
    const float reflection = reflection_probability(reflected);
    s.transmission = s.refraction = u_choice >= reflection;
    if (s.transmission) {
        // Equal indices: straight through, without rounding.
        s.wi = layers_.eta == 1.0f ? -wo : refract_direction(wo, h, cos_o, fresnel.cos_t, layers_.eta);
        s.eta = layers_.eta;
    } else {
        s.wi = reflect_direction(wo, h);
    }
    const bool reachable = s.transmission ? fresnel.cos_t > 0 && is_transmitted(s.wi, geometric_normal_)
                                          : s.wi.z > 0 && glm::dot(s.wi, geometric_normal_) > 0;
    if (!reachable) {
        s.wi = vec3(1, 0, 0);
        return s;
    }
    if (layers_.glass_delta) {
        s.delta = true;
        const float compression = mode == TransportMode::Radiance ? 1.0f / sqr(layers_.eta) : 1.0f;
        const float chosen = s.transmission ? 1.0f - reflection : reflection;
        s.pdf_sa = probability * chosen;
        s.weight = layers_.glass / s.pdf_sa *
                   (s.transmission ? (1.0f - max_component(reflected)) * compression * layers_.glass_tint : reflected);
    }
    return s;
}

Rgb Bsdf::albedo() const {
    if (kind_ != Kind::Layered) return diffuse_;
    const vec2 average = AlbedoTable::get().average(layers_.table_row);
    const float coat = layers_.coat_f0 * average.x + layers_.coat_f90 * average.y;
    Rgb sum = diffuse_ * sqr(1.0f - coat) + layers_.specular_f0 * average.x + layers_.specular_f90 * average.y +
              layers_.sheet * (average.x + average.y - coat);
    if (layers_.glass > 0) {
        // Mean of Schlick's curve over the hemisphere: F0 + (1 - F0)/21. Near enough for a picture of reflectance.
        const float f0 = normal_reflectance(layers_.eta);
        const Rgb reflected =
            layers_.glass_specular * glm::min(layers_.glass_color * (f0 + (1.0f - f0) / 21.0f), Rgb(1));
        sum += layers_.glass * (reflected + (1.0f - max_component(reflected)) * layers_.glass_tint);
    }
    return sum;
}

Bsdf make_bsdf(const Scene& scene, const ShadingPoint& point, float outside_ior) {
    const Material& material = scene.materials[point.material];
    if (material.unlit) return {};
    const Mesh& mesh = scene.meshes[scene.instances[point.instance].mesh];
    const vec3 geometric_normal = point.shading.to_local(point.geometric_normal);
    const Rgb base_color(surface_base_color(scene, mesh, point.triangle, point.u, point.v));

    const auto texel = [&](const TextureRef& reference, bool srgb) {
        if (!reference.used()) return vec4(1);
        return sample_texture(scene.textures[static_cast<size_t>(reference.texture)],
                              texture_coordinates(mesh, reference, point.triangle, point.u, point.v), srgb);
    };
    const vec4 metallic_roughness = texel(material.metallic_roughness_texture, false);
    Bsdf::Parameters p;
    p.geometric_normal = geometric_normal;
    p.base_color = glm::clamp(base_color, Rgb(0), Rgb(1));  // vertex colours may exceed 1, reflectance may not
    p.metallic = material.metallic * metallic_roughness.z;
    p.roughness = material.roughness * metallic_roughness.y;
    p.specular = material.specular * texel(material.specular_texture, false).w;
    p.transmission = material.transmission * texel(material.transmission_texture, false).x;
    if (p.metallic == 0 && p.specular == 0 && p.transmission == 0) return Bsdf::lambert(geometric_normal, p.base_color);
    p.specular_color = material.specular_color * Rgb(texel(material.specular_color_texture, true));
    p.ior = material.ior;
    p.solid = material.solid;
    // An index of 0 asks for a reflectance of 1 (KHR_materials_ior), which eta = 0 gives.
    const bool opaque = !(material.ior > 0 && outside_ior > 0);
    p.eta = opaque ? 0.0f : point.front_side ? material.ior / outside_ior : outside_ior / material.ior;
    return Bsdf::layered(p);
}

}  // namespace photond

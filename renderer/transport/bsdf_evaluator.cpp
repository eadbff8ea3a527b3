#include "renderer/transport/bsdf_evaluator.h"

#include "renderer/transport/bsdf_albedo_table.h"
#include "renderer/transport/bsdf_lobe_albedos_shared.h"
#include "renderer/transport/fresnel.h"
#include "renderer/transport/microfacet.h"

namespace photond {

namespace {

Vec3Lanes zero() { return {FloatLanes(0), FloatLanes(0), FloatLanes(0)}; }

Vec3Lanes select_each(const FloatMask& mask, const Vec3Lanes& a, const Vec3Lanes& b) {
    return {photond::select(mask, a.x, b.x), photond::select(mask, a.y, b.y), photond::select(mask, a.z, b.z)};
}

/// F0 a + F90 b, by colour.
Vec3Lanes mix_reflectance(const Rgb& f0, float f90, const FloatLanes& a, const FloatLanes& b) {
    return {f0.x * a + f90 * b, f0.y * a + f90 * b, f0.z * a + f90 * b};
}

}  // namespace

BsdfEvaluator::BsdfEvaluator(const Bsdf& bsdf, const vec3& wo) : bsdf_(bsdf), wo_(wo) {
    if (wo.z <= 0) bsdf_ = {};
    if (bsdf_.kind_ == Bsdf::Kind::Lambert) diffuse_ = bsdf_.diffuse_ * kInvPi;
    if (bsdf_.kind_ != Bsdf::Kind::Layered) return;
    if (!bsdf_.has_non_delta_) {
        bsdf_ = {};
        return;
    }
    const Bsdf::Layers& layers = bsdf_.layers_;
    lobes_ = bsdf_.lobe_probabilities(wo);
    if (lobes_.diffuse > 0) diffuse_ = bsdf_.diffuse_ * (1.0f - lobes_.coat) * kInvPi;
    has_coat_ = lobes_.diffuse > 0 && (layers.coat_f90 > 0 || layers.coat_f0 > 0);
    has_glass_ = lobes_.glass > 0 && !layers.glass_delta;
    has_others_below_ = has_glass_ || (lobes_.sheet > 0 && !layers.specular_delta);
    has_specular_ = lobes_.specular > 0 && !layers.specular_delta;
    stretched_cos_o_ = Ggx{layers.alpha}.stretched_cos(wo);
}

Vec3Lanes BsdfEvaluator::f_cos(const Vec3Lanes& wi) const {
    Vec3Lanes value = zero();
    if (bsdf_.kind_ == Bsdf::Kind::Nothing) return value;
    const FloatLanes from_geometric = dot(wi, broadcast(bsdf_.geometric_normal_));
    const FloatMask above = wi.z > 0 && from_geometric > 0;
    if (any_of(above) && !has_glass_) {
        value = diffuse(max(wi.z, FloatLanes(0)));
        if (has_specular_) add_specular(wi, value);
        value = select_each(above, value, zero());
    }
    if (has_others_below_) set_others(wi, (wi.z < 0 && from_geometric < 0) || (above && FloatMask(has_glass_)), value);
    return value;
}

/// [Kelemen and Szirmay-Kalos 2001, Eq. 4], or Lambert's.
Vec3Lanes BsdfEvaluator::diffuse(const FloatLanes& cos_i) const {
    const Vec3Lanes lambert = cos_i * broadcast(diffuse_);
    if (!has_coat_) return lambert;
    FloatLanes a, b;
    AlbedoTable::get().directional(cos_i, bsdf_.layers_.table_row, a, b);
    const FloatLanes coat = bsdf_.layers_.coat_f0 * a + bsdf_.layers_.coat_f90 * b;
    return max(1.0f - coat, FloatLanes(0)) * lambert;
}

/// GGX as in Bsdf::evaluate_layered().
void BsdfEvaluator::add_specular(const Vec3Lanes& wi, Vec3Lanes& f_cos) const {
    const Bsdf::Layers& layers = bsdf_.layers_;
    const float a2 = sqr(layers.alpha);
    const Vec3Lanes sum = broadcast(wo_) + wi;
    const Vec3Lanes h = 1.0f / sqrt(dot(sum, sum)) * sum;
    const FloatLanes stretched_h = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    const FloatLanes stretched_cos_i = sqrt(wi.z * wi.z + a2 * (wi.x * wi.x + wi.y * wi.y));
    const FloatLanes shadowing = wo_.z * stretched_cos_i + stretched_cos_o_ * wi.z;
    const FloatLanes lobe = 0.5f * kInvPi * a2 * wi.z / (stretched_h * stretched_h * shadowing);
    const FloatLanes m = min(max(1.0f - dot(broadcast(wo_), h), FloatLanes(0)), FloatLanes(1));
    const FloatLanes schlick = m * m * (m * m) * m;
    f_cos = f_cos + lobe * mix_reflectance(layers.specular_f0, layers.specular_f90, 1.0f - schlick, schlick);
}

LobeAlbedos BsdfEvaluator::lobe_albedos() const {
    if (bsdf_.kind_ == Bsdf::Kind::Nothing) return {};
    if (bsdf_.kind_ == Bsdf::Kind::Lambert) return {.diffuse = bsdf_.diffuse_};
    const Bsdf::Layers& layers = bsdf_.layers_;
    LobeAlbedos albedos{.alpha = layers.alpha};
    if (lobes_.diffuse > 0) {  // by the very table that the lobe is coupled by
        const vec2 average = AlbedoTable::get().average(layers.table_row);
        const float passed = 1.0f - (layers.coat_f0 * average.x + layers.coat_f90 * average.y);
        albedos.diffuse = bsdf_.diffuse_ * ((1.0f - lobes_.coat) * passed);
    }
    const bool has_sheet = lobes_.sheet > 0 && !layers.specular_delta;
    if (has_specular_ || has_sheet) {
        const vec2 ab = AlbedoTable::unraised().directional(wo_.z, layers.table_row);
        if (has_specular_) albedos.reflected = layers.specular_f0 * ab.x + layers.specular_f90 * ab.y;
        if (has_sheet)
            albedos.transmitted = layers.sheet * ((1.0f - layers.coat_f0) * ab.x + (1.0f - layers.coat_f90) * ab.y);
    }
    if (has_glass_) albedos.reflected += glass_albedo();
    return albedos;
}

/// What the solid's interface reflects: by exact Fresnel, for which there is no table.
Rgb BsdfEvaluator::glass_albedo() const {
    const Bsdf::Layers& layers = bsdf_.layers_;
    const auto reflectance = [&](float cos_h) {
        const DielectricFresnel fresnel = fresnel_dielectric(cos_h, layers.eta);
        return bsdf_.glass_reflectance(cos_h, fresnel.reflectance, fresnel.cos_t);
    };
    const vec3 wo(std::hypot(wo_.x, wo_.y), 0, wo_.z);
    const bool within = layers.eta < 1;
    return layers.glass * Ggx{layers.alpha}.directional_albedo<Rgb>(
                              wo, within ? GLASS_ALBEDO_AZIMUTHS_WITHIN : GLASS_ALBEDO_AZIMUTHS,
                              within ? GLASS_ALBEDO_CAPS_WITHIN : GLASS_ALBEDO_CAPS, true, reflectance);
}

/// Replaces the values of those lanes.
void BsdfEvaluator::set_others(const Vec3Lanes& wi, const FloatMask& lanes, Vec3Lanes& f_cos) const {
    for (size_t i = 0; i < kLanes; ++i) {
        if (!lanes[i]) continue;
        const Rgb value =
            bsdf_.evaluate_layered(wo_, {wi.x[i], wi.y[i], wi.z[i]}, TransportMode::Radiance, lobes_).f_cos;
        f_cos.x[i] = value.x, f_cos.y[i] = value.y, f_cos.z[i] = value.z;
    }
}

}  // namespace photond

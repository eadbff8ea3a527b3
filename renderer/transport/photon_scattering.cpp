#include "renderer/transport/photon_scattering.h"

#include <algorithm>

#include "renderer/transport/fresnel.h"
#include "renderer/transport/photon_scattering_shared.h"
#include "renderer/transport/sampling.h"

namespace photond {

namespace {

/// The shading normal that an eye at the end of `direction` sees, turned to the photon's side.
vec3 normal_of_eye(const ShadingPoint& point, const vec3& direction) {
    const float side = glm::dot(point.geometric_normal, direction) < 0 ? -1.0f : 1.0f;
    return normal_seen(point.smooth_normal, point.geometric_normal, -side * direction);
}

/// |cos_s(wi)| |cos_g(out)| / (|cos_g(wi)| |cos_s(out)|): between f |cos_s(out)|, which BSDF samples are made of, and
/// the change of power. 0 where light arrives from below the eye's shading plane.
float correction(const ShadingPoint& point, const vec3& shading_normal, const vec3& wi, const vec3& out) {
    const float cos_wi = glm::dot(shading_normal, wi);
    const float cos_out = std::fabs(glm::dot(shading_normal, out));
    const float geometric_wi = glm::dot(point.geometric_normal, wi);
    if (cos_wi <= 0 || cos_out <= 0 || geometric_wi <= 0) return 0;
    return cos_wi * std::fabs(glm::dot(point.geometric_normal, out)) / (geometric_wi * cos_out);
}

/// The lobes about one shading normal.
struct FramedBsdf {
    FramedBsdf(const ShadingPoint& point, const Bsdf& bsdf, const Frame& shading)
        : frame(shading), lobes(bsdf.with_geometric_normal(shading.to_local(point.geometric_normal))) {}

    BsdfValue evaluate(const vec3& wi, const vec3& out) const {
        return lobes.evaluate(frame.to_local(wi), frame.to_local(out), TransportMode::Importance);
    }

    Frame frame;
    Bsdf lobes;
};

/// Whether a mirror or a smooth interface about the geometric normal sends the light to where an eye would use that
/// normal, too.
bool leaves_below(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi) {
    const vec3 &ng = point.geometric_normal, &ns = point.smooth_normal;
    if (glm::dot(ns, reflect_direction(wi, ng)) <= 0) return true;
    const float eta = bsdf.refraction_eta(), cos_wi = glm::dot(ng, wi);
    if (eta <= 0) return false;
    const DielectricFresnel fresnel = fresnel_dielectric(cos_wi, eta);
    return fresnel.cos_t > 0 && glm::dot(ns, refract_direction(wi, ng, cos_wi, fresnel.cos_t, eta)) >= 0;
}

/// The diffuse lobe alone: drawn about the geometric normal, which reaches all directions with light and spares the
/// quotient of the cosines of the direction drawn.
PhotonScattering scatter_diffuse(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi, const vec2& u) {
    PhotonScattering scattering;
    const vec3 local = sample_cosine_hemisphere(u);
    scattering.direction = Frame(point.geometric_normal).to_world(local);
    // Again by the direction itself: a cosine of 0 has no density.
    const float cos_out = glm::dot(point.geometric_normal, scattering.direction);
    if (local.z <= 0 || cos_out <= 0) return scattering;
    scattering.pdf_sa = cos_out * kInvPi;
    scattering.weight = scatter_density(point, bsdf, wi, scattering.direction) * (kPi / cos_out);
    return scattering;
}

/// Of any lobes where the smooth normal leans: the two normals that directions are drawn about, and how many of them
/// about the geometric one.
struct LeaningLobes {
    LeaningLobes(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi)
        : shading{point, bsdf, point.shading}, geometric{point, bsdf, Frame(point.geometric_normal)} {
        // Light from below the smooth normal's plane is seen by eyes that use the geometric normal alone.
        if (point.shading.normal == point.geometric_normal) return;
        geometric_share = leaves_below(point, bsdf, wi) ? GEOMETRIC_SHARE_BELOW
                          : bsdf.has_non_delta()        ? GEOMETRIC_SHARE
                                                        : 0.0f;
    }

    FramedBsdf shading, geometric;
    float geometric_share = 0;
};

/// Any lobes where the smooth normal leans: drawn about the normal that the photon's own side sees, or about the
/// geometric one.
PhotonScattering scatter_leaning(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi, float u_lobe,
                                 const vec2& u) {
    const LeaningLobes lobes(point, bsdf, wi);
    const FramedBsdf &shading = lobes.shading, &geometric = lobes.geometric;
    const float geometric_share = lobes.geometric_share;

    const bool by_geometric = u_lobe < geometric_share;
    const float share = by_geometric ? geometric_share : 1.0f - geometric_share;
    u_lobe = std::min((by_geometric ? u_lobe : u_lobe - geometric_share) / share, 0x1.fffffep-1f);
    const FramedBsdf &drawn = by_geometric ? geometric : shading, &other = by_geometric ? shading : geometric;
    const BsdfSample sample = drawn.lobes.sample(drawn.frame.to_local(wi), u_lobe, u, TransportMode::Importance);
    if (!sample.valid()) return {};

    PhotonScattering scattering{
        .direction = drawn.frame.to_world(sample.wi), .delta = sample.delta, .refraction = sample.refraction};
    const vec3 eye_normal = normal_of_eye(point, scattering.direction);
    const float change = correction(point, eye_normal, wi, scattering.direction);
    if (change <= 0) return {};
    const bool seen_as_drawn = eye_normal == drawn.frame.normal;
    if (sample.delta) {
        // About another normal the lobe does not go this way.
        if (!seen_as_drawn) return {};
        scattering.weight = sample.weight * (change / share);
        scattering.pdf_sa = share * sample.pdf_sa;
        return scattering;
    }
    const BsdfValue of_other = geometric_share > 0 ? other.evaluate(wi, scattering.direction) : BsdfValue{};
    const Rgb f_cos = seen_as_drawn ? sample.weight * sample.pdf_sa : of_other.f_cos;
    scattering.pdf_sa = share * sample.pdf_sa + (1.0f - share) * of_other.pdf_sa;
    scattering.weight = f_cos * (change / scattering.pdf_sa);
    return scattering;
}

}  // namespace

PhotonScattering scatter_photon(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi_world, float u_lobe,
                                const vec2& u) {
    if (has_two_frames(point))
        return bsdf.is_diffuse() ? scatter_diffuse(point, bsdf, wi_world, u)
                                 : scatter_leaning(point, bsdf, wi_world, u_lobe, u);
    const BsdfSample sample = bsdf.sample(point.shading.to_local(wi_world), u_lobe, u, TransportMode::Importance);
    if (!sample.valid()) return {};
    return {point.shading.to_world(sample.wi), sample.weight, sample.pdf_sa, sample.delta, sample.refraction};
}

Rgb scatter_density(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi_world, const vec3& out_world) {
    const Frame frame(normal_of_eye(point, out_world));
    const Rgb f_cos = FramedBsdf(point, bsdf, frame).evaluate(wi_world, out_world).f_cos;
    return f_cos * correction(point, frame.normal, wi_world, out_world);
}

float scatter_pdf(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi_world, const vec3& out_world) {
    if (!has_two_frames(point))
        return bsdf.evaluate(point.shading.to_local(wi_world), point.shading.to_local(out_world)).pdf_sa;
    if (bsdf.is_diffuse()) return cosine_hemisphere_pdf(glm::dot(point.geometric_normal, out_world));
    const LeaningLobes lobes(point, bsdf, wi_world);
    float pdf_sa = (1.0f - lobes.geometric_share) * lobes.shading.evaluate(wi_world, out_world).pdf_sa;
    if (lobes.geometric_share > 0)
        pdf_sa += lobes.geometric_share * lobes.geometric.evaluate(wi_world, out_world).pdf_sa;
    return pdf_sa;
}

/// Flat meshes with normals of their own differ by rounding alone.
bool has_two_frames(const ShadingPoint& point) {
    const vec3 difference = point.smooth_normal - point.geometric_normal;
    return glm::dot(difference, difference) > 1e-10f;
}

}  // namespace photond

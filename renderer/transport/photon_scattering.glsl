// GLSL twin of transport/photon_scattering.h and .cpp: scattering of light paths, which must carry what paths from the
// eye would have found. Reasons and references are there.
#ifndef PHOTOND_PHOTON_SCATTERING_GLSL
#define PHOTOND_PHOTON_SCATTERING_GLSL

#include "renderer/transport/bsdf.glsl"
#include "renderer/transport/medium_stack.glsl"
#include "renderer/transport/photon_scattering_shared.h"
#include "renderer/transport/surface.glsl"

struct PhotonScattering {
    vec3 direction;  // world, unit: where the photon goes on to
    vec3 weight;     // power changes by this factor, over the probability of the direction
    float pdf_sa;    // of the direction [1/sr], as scatter_pdf() says; of a delta lobe the probability of its choice
    bool delta;
    bool refraction;  // the medium changes: medium_stack_cross()
};
const PhotonScattering NO_PHOTON_SCATTERING = PhotonScattering(vec3(0.0), vec3(0.0), 0.0, false, false);

bool photon_scattering_valid(PhotonScattering scattering) { return !is_black(scattering.weight); }

/// Whether eyes may see the point in two frames. Flat meshes with normals of their own differ by rounding alone.
bool has_two_frames(ShadingPoint point) {
    if (!NEEDS_SMOOTH_NORMALS && !NEEDS_NORMAL_MAPS) return false;
    const vec3 difference = point.smooth_normal - point.geometric_normal;
    return dot(difference, difference) > 1e-10;
}

/// The shading normal that an eye at the end of `direction` sees, turned to the photon's side.
vec3 normal_of_eye(ShadingPoint point, vec3 direction) {
    const float side = dot(point.geometric_normal, direction) < 0 ? -1.0 : 1.0;
    return normal_seen(point.smooth_normal, point.geometric_normal, -side * direction);
}

/// |cos_s(wi)| |cos_g(out)| / (|cos_g(wi)| |cos_s(out)|): between f |cos_s(out)|, which BSDF samples are made of, and
/// the change of power. 0 where light arrives from below the eye's shading plane.
float correction(ShadingPoint point, vec3 shading_normal, vec3 wi, vec3 outgoing) {
    const float cos_wi = dot(shading_normal, wi);
    const float cos_out = abs(dot(shading_normal, outgoing));
    const float geometric_wi = dot(point.geometric_normal, wi);
    if (cos_wi <= 0 || cos_out <= 0 || geometric_wi <= 0) return 0.0;
    return cos_wi * abs(dot(point.geometric_normal, outgoing)) / (geometric_wi * cos_out);
}

/// The lobes about one shading normal.
BsdfValue evaluate_framed(ShadingPoint point, Bsdf bsdf, Frame frame, vec3 wi, vec3 outgoing) {
    const Bsdf lobes = bsdf_with_geometric_normal(bsdf, to_local(frame, point.geometric_normal));
    return bsdf_evaluate(lobes, to_local(frame, wi), to_local(frame, outgoing), TRANSPORT_IMPORTANCE);
}

/// Whether a mirror or a smooth interface about the geometric normal sends the light to where an eye would use that
/// normal, too.
bool leaves_below(ShadingPoint point, Bsdf bsdf, vec3 wi) {
    const vec3 ng = point.geometric_normal, ns = point.smooth_normal;
    if (dot(ns, reflect_direction(wi, ng)) <= 0) return true;
    const float eta = bsdf_refraction_eta(bsdf), cos_wi = dot(ng, wi);
    if (eta <= 0) return false;
    const DielectricFresnel fresnel = fresnel_dielectric(cos_wi, eta);
    return fresnel.cos_t > 0 && dot(ns, refract_direction(wi, ng, cos_wi, fresnel.cos_t, eta)) >= 0;
}

/// What scatter_photon() draws from: the share of the light arriving from `wi_world` that lobes which are no delta send
/// to each solid angle about `out_world` [1/sr] (both unit). 0 below the surface.
vec3 scatter_density(ShadingPoint point, Bsdf bsdf, vec3 wi_world, vec3 out_world) {
    const Frame frame = make_frame(normal_of_eye(point, out_world));
    const vec3 f_cos = evaluate_framed(point, bsdf, frame, wi_world, out_world).f_cos;
    return f_cos * correction(point, frame.normal, wi_world, out_world);
}

/// The diffuse lobe alone: drawn about the geometric normal, which reaches all directions with light and spares the
/// quotient of the cosines of the direction drawn.
PhotonScattering scatter_diffuse(ShadingPoint point, Bsdf bsdf, vec3 wi, vec2 u) {
    PhotonScattering scattering = NO_PHOTON_SCATTERING;
    const vec3 local = sample_cosine_hemisphere(u);
    scattering.direction = to_world(make_frame(point.geometric_normal), local);
    // Again by the direction itself: a cosine of 0 has no density.
    const float cos_out = dot(point.geometric_normal, scattering.direction);
    if (local.z <= 0 || cos_out <= 0) return scattering;
    scattering.pdf_sa = cos_out * INV_PI;
    scattering.weight = scatter_density(point, bsdf, wi, scattering.direction) * (PI / cos_out);
    return scattering;
}

/// Of any lobes where the smooth normal leans: how many directions are drawn about the geometric normal.
float share_about_geometric(ShadingPoint point, Bsdf bsdf, vec3 wi) {
    // Light from below the smooth normal's plane is seen by eyes that use the geometric normal alone.
    if (point.shading.normal == point.geometric_normal) return 0.0;
    return leaves_below(point, bsdf, wi) ? GEOMETRIC_SHARE_BELOW : bsdf_has_non_delta(bsdf) ? GEOMETRIC_SHARE : 0.0;
}

/// Any lobes where the smooth normal leans: drawn about the normal that the photon's own side sees, or about the
/// geometric one.
PhotonScattering scatter_leaning(ShadingPoint point, Bsdf bsdf, vec3 wi, float u_lobe, vec2 u) {
    const float geometric_share = share_about_geometric(point, bsdf, wi);
    const bool by_geometric = u_lobe < geometric_share;
    const float share = by_geometric ? geometric_share : 1.0 - geometric_share;
    u_lobe = min((by_geometric ? u_lobe : u_lobe - geometric_share) / share, BELOW_ONE);
    const Frame geometric = make_frame(point.geometric_normal);
    Frame drawn = point.shading, other = geometric;
    if (by_geometric) {
        drawn = geometric;
        other = point.shading;
    }
    const Bsdf lobes = bsdf_with_geometric_normal(bsdf, to_local(drawn, point.geometric_normal));
    const BsdfSample s = bsdf_sample(lobes, to_local(drawn, wi), u_lobe, u, TRANSPORT_IMPORTANCE);
    if (!bsdf_sample_valid(s)) return NO_PHOTON_SCATTERING;

    PhotonScattering scattering = PhotonScattering(to_world(drawn, s.wi), vec3(0.0), 0.0, s.delta, s.refraction);
    const vec3 eye_normal = normal_of_eye(point, scattering.direction);
    const float change = correction(point, eye_normal, wi, scattering.direction);
    if (change <= 0) return NO_PHOTON_SCATTERING;
    const bool seen_as_drawn = eye_normal == drawn.normal;
    if (s.delta) {
        // About another normal the lobe does not go this way.
        if (!seen_as_drawn) return NO_PHOTON_SCATTERING;
        scattering.weight = s.weight * (change / share);
        scattering.pdf_sa = share * s.pdf_sa;
        return scattering;
    }
    BsdfValue of_other = NO_BSDF_VALUE;
    if (geometric_share > 0) of_other = evaluate_framed(point, bsdf, other, wi, scattering.direction);
    const vec3 f_cos = seen_as_drawn ? s.weight * s.pdf_sa : of_other.f_cos;
    scattering.pdf_sa = share * s.pdf_sa + (1.0 - share) * of_other.pdf_sa;
    scattering.weight = f_cos * (change / scattering.pdf_sa);
    return scattering;
}

/// Scatters light that arrived at `point` (made for the photon's ray) from `wi_world` (unit, away from the surface) by
/// the lobes in `bsdf`, which is part of (or all of) the BSDF at that point as looked at from wi_world. The numbers are
/// uniform in [0, 1).
PhotonScattering scatter_photon(ShadingPoint point, Bsdf bsdf, vec3 wi_world, float u_lobe, vec2 u) {
    if (has_two_frames(point)) {
        if (bsdf_is_diffuse(bsdf)) return scatter_diffuse(point, bsdf, wi_world, u);
        return scatter_leaning(point, bsdf, wi_world, u_lobe, u);
    }
    const BsdfSample s = bsdf_sample(bsdf, to_local(point.shading, wi_world), u_lobe, u, TRANSPORT_IMPORTANCE);
    if (!bsdf_sample_valid(s)) return NO_PHOTON_SCATTERING;
    return PhotonScattering(to_world(point.shading, s.wi), s.weight, s.pdf_sa, s.delta, s.refraction);
}

/// Density [1/sr] with which it draws `out_world` by lobes that are no delta.
float scatter_pdf(ShadingPoint point, Bsdf bsdf, vec3 wi_world, vec3 out_world) {
    const bool two_frames = has_two_frames(point);
    if (two_frames && bsdf_is_diffuse(bsdf)) return cosine_hemisphere_pdf(dot(point.geometric_normal, out_world));
    const float geometric_share = two_frames ? share_about_geometric(point, bsdf, wi_world) : 0.0;
    // A loop: drivers copy functions into each of their callers.
    const uint frames = geometric_share > 0.0 ? 2 : 1;
    float pdf_sa = 0.0;
    for (uint frame = 0; frame < frames; ++frame) {
        const bool by_shading = frame == 0;
        Frame about = point.shading;
        if (!by_shading) about = make_frame(point.geometric_normal);
        pdf_sa += (by_shading ? 1.0 - geometric_share : geometric_share) *
                  evaluate_framed(point, bsdf, about, wi_world, out_world).pdf_sa;
    }
    return pdf_sa;
}

#endif

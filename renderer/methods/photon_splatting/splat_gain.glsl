// GLSL twin of methods/photon_splatting/splat_lanes.h: what one splat brings to one visible point.
#ifndef PHOTOND_SPLAT_GAIN_GLSL
#define PHOTOND_SPLAT_GAIN_GLSL

#include "renderer/backends/gpu/scene.glsl"
#include "renderer/methods/photon_splatting/connect_weight.glsl"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/photons/kernel.glsl"

/// Twin of VisibleCluster::clamp_sq_m2().
float clamp_sq_m2(float splat_radius_m) { return sqr(SPLAT_CLAMP_SHARE * splat_radius_m); }

bool is_general(SplatPoint point) { return !ONLY_LAMBERT && (point.kind & POINT_GENERAL) != 0u; }

/// Whether light that travels along `d` (of any length) reaches the point's lit side.
bool faces(SplatPoint point, vec3 d) {
    if (!ONLY_LAMBERT && point.normal == vec3(0.0)) return true;
    return dot(point.normal, d) < 0.0 && dot(point.geometric_normal, d) < 0.0;
}

/// A photon that connects. Irradiance [W m^-2] over the splat's intensity; for receivers that are not Lambert without the
/// receiver's cosine. False: it is not lit.
bool connect_gain(Splat splat, SplatPoint point, KernelRecord kernel, out float gain) {
    gain = 0.0;
    const float radius_m = splat.radius * point.splat_radius_m, radius_sq = sqr(radius_m);
    const float inverse_radius_sq = 1.0 / radius_sq;
    const vec3 d = point.position - splat.origin;
    const float along = dot(d, splat.axis), d_sq = dot(d, d), height = dot(d, splat.normal);
    const vec3 across = d - along * splat.axis;
    const float u_sq = along > 0.0 ? dot(across, across) : d_sq;
    if (!(u_sq < radius_sq && height > 0.0)) return false;
    if (!faces(point, d)) return false;

    const float inverse_d = 1.0 / sqrt(max(d_sq, 1e-37));
    if (height < radius_m) {
        const float disc_sq = radius_sq * sqr(splat.disc);
        if (!(u_sq < disc_sq)) return true;  // reached, by no light
        const float factor =
            connect_factor(d_sq, min(height * inverse_d, 1.0), disc_sq, clamp_sq_m2(point.splat_radius_m));
        gain = factor * (INV_PI * radius_sq / disc_sq);
    } else {
        gain = kernel_evaluate(kernel, min(u_sq * inverse_radius_sq, 1.0));
    }
    gain *= inverse_radius_sq;
    if (!is_general(point)) gain *= -dot(point.normal, d) * inverse_d;
    return true;
}

/// A photon that lights along its direction.
bool beam_gain(Splat splat, SplatPoint point, KernelRecord kernel, out float gain) {
    gain = 0.0;
    const vec3 d = point.position - splat.origin;
    const float along = dot(d, splat.axis);
    const vec3 across = d - along * splat.axis;
    const float u_sq = dot(across, across), radius_sq = sqr(splat.radius);
    if (!(u_sq < radius_sq && along >= splat.near_m && along <= splat.far_m)) return false;
    if (!faces(point, splat.axis)) return false;
    gain = kernel_evaluate(kernel, min(u_sq / radius_sq, 1.0));
    if (!is_general(point)) gain *= -dot(point.normal, splat.axis);
    return true;
}

#endif

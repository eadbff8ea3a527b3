#pragma once
// Scattering of light paths. A path from the light must carry what a path from the eye would have found along the same
// vertices, also where shading normals differ from geometric ones (interpolated normals, normal maps) and where light
// is refracted.
//
// With f the BSDF as the eye's paths use it (looked at from the direction the photon leaves to), power changes by
//   f(w_out, w_in) |cos_s(w_in)| |cos_g(w_out)| / (|cos_g(w_in)| p(w_out))
// [Veach 1997, sec. 5.3], cos_s against the shading and cos_g against the geometric normal. Where both normals are the
// same this is the BSDF sample's own weight, in TransportMode::Importance.
//
// The eye's shading frame depends on where it looks from: an eye below the smooth normal's plane (but above the
// surface) uses the geometric normal (surface.h). What goes there is found by drawing some of the directions about the
// geometric normal, and joining both ways to draw by their balance heuristic.
//
// [Veach 1997] Robust Monte Carlo Methods for Light Transport Simulation. PhD thesis, Stanford.

#include "renderer/transport/bsdf.h"
#include "renderer/transport/medium_stack.h"

namespace photond {

struct PhotonScattering {
    vec3 direction{0};  // world, unit: where the photon goes on to
    Rgb weight{0};      // power changes by this factor, over the probability of the direction
    float pdf_sa = 0;   // of the direction [1/sr], as scatter_pdf() says; of a delta lobe the probability of its choice
    bool delta = false;
    bool refraction = false;  // the medium changes: MediumStack::cross()

    bool valid() const { return !is_black(weight); }
};

/// Scatters light that arrived at `point` (made for the photon's ray) from `wi_world` (unit, away from the surface) by
/// the lobes in `bsdf`, which is part of (or all of) the BSDF at that point as looked at from wi_world. The numbers are
/// uniform in [0, 1).
PhotonScattering scatter_photon(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi_world, float u_lobe,
                                const vec2& u);

/// What scatter_photon() draws from: the share of the light arriving from `wi_world` that lobes which are no delta send
/// to each solid angle about `out_world` [1/sr] (both unit). 0 below the surface.
Rgb scatter_density(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi_world, const vec3& out_world);

/// Density [1/sr] with which it draws `out_world` by lobes that are no delta.
float scatter_pdf(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wi_world, const vec3& out_world);

/// Whether eyes may see the point in two frames: its smooth normal is not its geometric one.
bool has_two_frames(const ShadingPoint& point);

}  // namespace photond

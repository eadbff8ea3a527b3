#pragma once
// Density estimation: reflected radiance and irradiance from the photons about a point.
//
//   L_r(x, wo) = sum_p K(|y_p - x|; r) f_r(x, w_p, wo) dPhi_p        (methods.md, "photon_mapping")
//
// A photon's power is flux through the geometric surface; where the shading normal differs, f_r is the BSDF as paths
// from the eye see it: f(wo, w_p) |cos_s(w_p)| / |cos_g(w_p)|. [Veach 1997, sec. 5.3]

#include <optional>

#include "renderer/photons/kernel.h"
#include "renderer/photons/photon_map.h"
#include "renderer/transport/bsdf.h"

namespace photond {

class DiscCoverage;

struct EstimateSettings {
    Kernel kernel;
    /// Photons farther than this from the tangent plane are refused; a quarter of the disc's radius when not given.
    std::optional<float> disc_thickness_m;
    /// Weight photons by |n . n_p| times (1 - distance from the plane / thickness) instead of refusing at 60 degrees
    /// and at the thickness. Loses energy; for comparison only.
    bool soft_disc = false;
    /// Divide by the part of the kernel that lies on surface which light can reach; nullptr: by all of it.
    const DiscCoverage* coverage = nullptr;
};

/// Photons whose geometric normal makes more than 60 degrees with that of the point are refused.
inline constexpr float kDiscCosine = 0.5f;

struct RadianceEstimate {
    Rgb radiance{0};        // [W m^-2 sr^-1], all photons that passed
    Rgb delta_radiance{0};  // the part of those whose scatterings were all delta (layer "caustic")
    uint32_t photons = 0;   // that passed the tests
    float radius_m = 0;     // of the disc
};

/// Reflected (and, by rough transmission, transmitted) radiance towards `wo` (local to point.shading) by the non-delta
/// lobes of `bsdf`. Photons with more than `most_scatterings` are left out. `scratch` is the calling thread's. `turn`,
/// a random number, is for the coverage of the disc.
RadianceEstimate estimate_radiance(const PhotonMap& map, const EstimateSettings& settings, const ShadingPoint& point,
                                   const Bsdf& bsdf, const vec3& wo, uint32_t most_scatterings, Neighbours& scratch,
                                   uint32_t turn = 0);

/// Irradiance [W m^-2] at a place with that geometric normal (unit, the side that is lit).
Rgb estimate_irradiance(const PhotonMap& map, const EstimateSettings& settings, const vec3& position,
                        const vec3& normal, uint32_t most_scatterings, Neighbours& scratch, uint32_t turn = 0);

}  // namespace photond

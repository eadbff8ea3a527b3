#pragma once
// The first radius that is best for a place, as a pilot's photons tell it there (trained_radii.h has the formula).

#include <optional>

#include "renderer/photons/radiance_estimate.h"

namespace photond {

/// Of the pilot's nearest photons, that a map which is asked is to find: those of the largest disc.
inline constexpr uint32_t kRadiusPilotNearest = 1024;

/// Where light is looked up.
struct RadiusPlace {
    const ShadingPoint& surface;
    const Bsdf& bsdf;
    vec3 wo;  // local to surface.shading
    uint32_t most_scatterings = UINT32_MAX;
};

/// r_0 of the constant kernel, of a schedule r_i = r_0 i^(-1/6) [m]; nothing where the pilot has no photon in reach.
/// `pilot_passes`: how many passes' photons the pilot has.
std::optional<float> first_radius_at(const RadiusPlace& place, const PhotonMap& pilot, double pilot_passes,
                                     const EstimateSettings& estimate, Neighbours& scratch);

/// What r_0 is multiplied by for a schedule of radius_schedule.h with that alpha, whose radii tend to
/// r_1 i^((alpha - 1) / 2) / sqrt(Gamma(1 + alpha)).
double over_schedule(double alpha);

}  // namespace photond

#pragma once
// Density estimation: reflected radiance and irradiance from the photons about a point.
//
//   L_r(x, wo) = sum_p K(|y_p - x|; r) f_r(x, w_p, wo) dPhi_p        (methods.md, "photon_mapping")
//
// A photon's power is flux through the surface it lies on, L |cos_p| dw dA with the cosine to the normal there. Where
// the shading normal differs from the geometric one, f_r is the BSDF as paths from the eye see it, of that radiance:
// f(wo, w_p) |cos_s(w_p)| / |cos_p(w_p)|. [Veach 1997, sec. 5.3] By the cosine to the normal of the point that is
// shaded, light that grazes it and meets the next facet of a column steeply would count many times.

#include <array>
#include <optional>

#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/kernel.h"
#include "renderer/photons/photon_map.h"
#include "renderer/transport/bsdf.h"

namespace photond {

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

/// How far from its plane a disc of that radius counts photons.
inline float disc_thickness_m(const EstimateSettings& settings, float radius_m) {
    return settings.disc_thickness_m.value_or(0.25f * radius_m);
}

/// What photons on a disc tell of how light varies there: sums over those that are scattered towards the eye, w the
/// light that one of them brings by a kernel of 1 [W sr^-1], its channels added with `channels`; t = 2 d^2 / r^2 - 1
/// with its distance d from the centre (t has mean 0 in light that varies linearly). Sectors are eight equal parts of
/// the disc, by direction from the centre.
struct DiscMoments {
    static constexpr size_t kSectors = 8;

    Rgb channels = kLuminanceWeights;
    double photons = 0, w = 0, w_sq = 0, w_t = 0;
    std::array<double, kSectors> sectors{};  // w by sector
};

/// How one lookup is made.
struct DiscQuery {
    uint32_t turn = 0;  // a random number, for the coverage of the disc
    DiscCare care = DiscCare::Fine;
    float most_radius_m = kInfinity;  // of a larger disc only the radius is wanted
    std::optional<float> radius_m{};  // of the disc; the map's own search says where it is not given
    DiscMoments* moments = nullptr;   // to add to
};

struct RadianceEstimate {
    Rgb radiance{0};         // [W m^-2 sr^-1], all photons that passed
    Rgb delta_radiance{0};   // the part of those whose scatterings were all delta (layer "caustic")
    uint32_t photons = 0;    // that passed the tests
    uint32_t scattered = 0;  // of them: that bring any light
    float radius_m = 0;      // of the disc
};

/// Reflected (and, by rough transmission, transmitted) radiance towards `wo` (local to point.shading) by the non-delta
/// lobes of `bsdf`. Photons with more than `most_scatterings` are left out. `scratch` is the calling thread's.
RadianceEstimate estimate_radiance(const PhotonMap& map, const EstimateSettings& settings, const ShadingPoint& point,
                                   const Bsdf& bsdf, const vec3& wo, uint32_t most_scatterings, Neighbours& scratch,
                                   const DiscQuery& query = {});

/// Irradiance [W m^-2] at a place with that geometric normal (unit, the side that is lit).
Rgb estimate_irradiance(const PhotonMap& map, const EstimateSettings& settings, const vec3& position,
                        const vec3& normal, uint32_t most_scatterings, Neighbours& scratch,
                        const DiscQuery& query = {});

}  // namespace photond

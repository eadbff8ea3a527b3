#pragma once
// The maps of a pass, and what all its tiles share.

#include <optional>

#include "renderer/eye/eye_scene.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/precomputed_irradiance.h"
#include "renderer/photons/shadow_photons.h"

namespace photond {

/// Made anew by each pass. Maps that are not needed stay empty.
struct PassMaps {
    PhotonMap global;
    PhotonMap caustic;
    std::optional<PrecomputedIrradiance> irradiance;  // of the global map
    std::optional<ShadowPhotons> shadow;
};

struct PhotonMappingScene : EyeScene {
    PhotonMappingScene(const RenderContext& context, const PhotonMappingParams& parameters)
        : EyeScene(context, parameters.sampler, parameters.max_scatterings()),
          params(parameters),
          splits(parameters.splits(context.view.film_size.pixels())),
          search_radius_m(parameters.search_radius_m(context.scene.bounds.radius())),
          estimate{.kernel = Kernel(parameters.kernel, parameters.cone_k),
                   .disc_thickness_m = parameters.disc_thickness_m,
                   .soft_disc = parameters.soft_disc} {
        if (parameters.boundary == DiscBoundary::Clip)
            estimate.coverage = &coverage.emplace(scene, intersector, search_radius_m);
    }

    bool final_gather() const { return params.gather == Gather::Final; }
    /// Scatterings left to a photon that is looked up after so many of the eye's path, the lookup's own included.
    uint32_t photon_scatterings(uint32_t scatterings) const {
        return max_scatterings == UINT32_MAX ? UINT32_MAX : max_scatterings - std::min(max_scatterings, scatterings);
    }

    const PhotonMappingParams params;
    const Splits splits;
    const float search_radius_m;
    const bool lights_can_be_met = !scene.triangle_lights.empty() || scene.environment.has_value();
    std::optional<DiscCoverage> coverage;
    EstimateSettings estimate;
};

/// Light of the caustic map that is scattered by `rough` (f_d). None when `most_scatterings` is 0.
inline RadianceEstimate estimate_caustic(const PhotonMappingScene& shared, const PassMaps& maps,
                                         const ShadingPoint& surface, const Bsdf& rough, const vec3& wo,
                                         uint32_t most_scatterings, Neighbours& scratch, uint32_t turn) {
    if (maps.caustic.empty() || most_scatterings == 0) return {};
    return estimate_radiance(maps.caustic, shared.estimate, surface, rough, wo, most_scatterings, scratch, turn);
}

/// The same of the global map.
inline RadianceEstimate estimate_global(const PhotonMappingScene& shared, const PassMaps& maps,
                                        const ShadingPoint& surface, const Bsdf& rough, const vec3& wo,
                                        uint32_t most_scatterings, Neighbours& scratch, uint32_t turn) {
    if (maps.global.empty() || most_scatterings == 0) return {};
    return estimate_radiance(maps.global, shared.estimate, surface, rough, wo, most_scatterings, scratch, turn);
}

/// The same at the end of a gather ray: from the precomputed irradiance where that fits.
inline RadianceEstimate estimate_global_at_end(const PhotonMappingScene& shared, const PassMaps& maps,
                                               const ShadingPoint& surface, const Bsdf& rough, const vec3& wo,
                                               uint32_t most_scatterings, Neighbours& scratch, uint32_t turn) {
    // Irradiance was summed for one number of scatterings; a gather ray that followed specular surfaces has fewer left.
    if (!maps.irradiance || maps.irradiance->most_scatterings() != most_scatterings ||
        rough.has_non_delta_transmission())
        return estimate_global(shared, maps, surface, rough, wo, most_scatterings, scratch, turn);
    const auto found = maps.irradiance->find(surface.position, surface.geometric_normal);
    RadianceEstimate estimate;
    // Where nothing is found the disc is as large as discs get.
    estimate.radius_m = found ? found->radius_m : shared.search_radius_m;
    if (found) {
        estimate.radiance = rough.albedo() * kInvPi * found->irradiance;
        estimate.photons = 1;
    }
    return estimate;
}

/// What the shadow photons say of a light source (LightSample::source): Unknown without any.
inline LightSeen light_seen(const PassMaps& maps, const vec3& position, const vec3& geometric_normal, uint32_t source,
                            Neighbours& scratch) {
    return maps.shadow ? maps.shadow->seen(position, geometric_normal, source, scratch) : LightSeen::Unknown;
}

}  // namespace photond

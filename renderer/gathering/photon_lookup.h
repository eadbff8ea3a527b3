#pragma once
// The maps of a pass, what all its tiles share, and how light is looked up in the maps.

#include <optional>

#include "renderer/eye/eye_scene.h"
#include "renderer/eye/visible_point.h"
#include "renderer/gathering/gathering_params.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/precomputed_irradiance.h"
#include "renderer/photons/precomputed_irradiance_shared.h"
#include "renderer/photons/shadow_photons.h"

namespace photond {

/// Made anew by each pass. Maps that are not needed stay empty.
struct PassMaps {
    PhotonMap global;
    PhotonMap caustic;
    std::optional<PrecomputedIrradiance> irradiance;  // of the global map
    std::optional<ShadowPhotons> shadow;
};

struct GatheringScene : EyeScene {
    GatheringScene(const RenderContext& context, const GatheringParams& parameters)
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

    /// Scatterings left to a photon that is looked up after so many of the eye's path, the lookup's own included.
    uint32_t photon_scatterings(uint32_t scatterings) const {
        return max_scatterings == UINT32_MAX ? UINT32_MAX : max_scatterings - std::min(max_scatterings, scatterings);
    }

    const GatheringParams& params;  // the method's
    const Splits splits;
    const float search_radius_m;
    const bool lights_can_be_met = !scene.triangle_lights.empty() || scene.environment.has_value();
    std::optional<DiscCoverage> coverage;
    EstimateSettings estimate;
};

/// The end of a gather ray, where the rough part of the surface (f_d) scatters light of the maps.
struct RayEnd {
    const ShadingPoint& surface;
    const Bsdf& rough;
    vec3 wo;       // local
    Rgb to_pixel;  // what radiance there brings to the pixel
    uint32_t pixel;
    uint32_t most_scatterings;  // of photons
    uint32_t disc_turn;         // DiscQuery::turn
    float most_radius_m;        // of the global map's disc
};

/// Brings the light of the maps to the ends of gather rays, at once or later. One thread's.
class RayEndLookups {
public:
    virtual ~RayEndLookups() = default;
    /// False: the global map's disc there is larger than is wanted, and that map's light is left out.
    virtual bool add(const RayEnd& end, PassImage& image) = 0;
};

/// Light of the caustic map that is scattered by `rough` (f_d). None when `most_scatterings` is 0.
inline RadianceEstimate estimate_caustic(const GatheringScene& shared, const PassMaps& maps,
                                         const ShadingPoint& surface, const Bsdf& rough, const vec3& wo,
                                         uint32_t most_scatterings, Neighbours& scratch, const DiscQuery& query) {
    if (maps.caustic.empty() || most_scatterings == 0) return {};
    return estimate_radiance(maps.caustic, shared.estimate, surface, rough, wo, most_scatterings, scratch, query);
}

/// The same of the global map.
inline RadianceEstimate estimate_global(const GatheringScene& shared, const PassMaps& maps, const ShadingPoint& surface,
                                        const Bsdf& rough, const vec3& wo, uint32_t most_scatterings,
                                        Neighbours& scratch, const DiscQuery& query) {
    if (maps.global.empty() || most_scatterings == 0) return {};
    return estimate_radiance(maps.global, shared.estimate, surface, rough, wo, most_scatterings, scratch, query);
}

/// The same at the end of a gather ray: from the precomputed irradiance where that fits.
inline RadianceEstimate estimate_global_at_end(const GatheringScene& shared, const PassMaps& maps,
                                               const ShadingPoint& surface, const Bsdf& rough, const vec3& wo,
                                               uint32_t most_scatterings, Neighbours& scratch, const DiscQuery& query) {
    // Irradiance was summed for one number of scatterings; a gather ray that followed specular surfaces has fewer left.
    float weight = 1;
    if (maps.irradiance && maps.irradiance->most_scatterings() == most_scatterings &&
        !rough.has_non_delta_transmission()) {
        const PrecomputedIrradiance::Lookup lookup = maps.irradiance->find(surface.position, surface.geometric_normal);
        if (const auto& found = lookup.found)
            return {.radiance = rough.albedo() * kInvPi * found->irradiance, .photons = 1, .radius_m = found->radius_m};
        if (lookup.is_dark) {
            // A disc here is as large as discs get, costs the most and holds next to nothing: one of four is asked.
            if (query.most_radius_m < shared.search_radius_m || disc_lot(query.turn) >= DARK_DISC_SHARE)
                return {.radius_m = shared.search_radius_m};
            weight = 1 / DARK_DISC_SHARE;
        }
    }
    RadianceEstimate estimate = estimate_global(shared, maps, surface, rough, wo, most_scatterings, scratch, query);
    estimate.radiance *= weight;
    return estimate;
}

/// Looks the maps up where rays end, one by one.
class SearchedRayEnds final : public RayEndLookups {
public:
    /// Both are borrowed.
    SearchedRayEnds(const GatheringScene& shared, const PassMaps& maps) : shared_(shared), maps_(maps) {}

    bool add(const RayEnd& end, PassImage& image) override {
        const auto& [surface, rough, wo, to_pixel, pixel, most, turn, most_radius_m] = end;
        DiscQuery query{.turn = turn, .care = DiscCare::Coarse};
        const RadianceEstimate caustic = estimate_caustic(shared_, maps_, surface, rough, wo, most, scratch_, query);
        query.most_radius_m = most_radius_m;
        RadianceEstimate global = estimate_global_at_end(shared_, maps_, surface, rough, wo, most, scratch_, query);
        const bool too_large = global.radius_m > most_radius_m;
        if (too_large) global = {};
        image.of<Layer::Indirect>()[pixel] += to_pixel * (caustic.radiance + global.radiance);
        if (image.layers.has(Layer::PhotonCount))
            image.of<Layer::PhotonCount>()[pixel] += static_cast<float>(caustic.photons + global.photons);
        return !too_large;
    }

private:
    const GatheringScene& shared_;
    const PassMaps& maps_;
    Neighbours scratch_;
};

/// What the shadow photons say of a light source (LightSample::source): Unknown without any.
inline LightSeen light_seen(const PassMaps& maps, const vec3& position, const vec3& geometric_normal, uint32_t source,
                            Neighbours& scratch) {
    return maps.shadow ? maps.shadow->seen(position, geometric_normal, source, scratch) : LightSeen::Unknown;
}

}  // namespace photond

// GLSL twin of gathering/photon_lookup.h: the maps of a pass, and what all its threads share, in the
// bindings of set 0 below 9. Define NEAREST_GROUP before (radiance_estimate.glsl).
#ifndef PHOTOND_PHOTON_LOOKUP_GLSL
#define PHOTOND_PHOTON_LOOKUP_GLSL

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#define SPLIT_POINTS_BINDING 4
#define MAPPING_BINDING 5
#define GRID_STARTS_BINDING 6
#define GRID_PLACES_BINDING 7
#define MAP_POWERS_BINDING 8
#include "renderer/gathering/split_samplers.glsl"
#include "renderer/eye/specular_walk.glsl"

layout(constant_id = FINAL_GATHER_ID) const bool FINAL_GATHER = false;
layout(constant_id = GLOBAL_MAP_ID) const bool GLOBAL_MAP = true;
layout(constant_id = CAUSTIC_MAP_ID) const bool CAUSTIC_MAP = true;

layout(set = 0, binding = MAPPING_BINDING, scalar) readonly buffer Mapping { GatheringConstants mapping; };

#define ESTIMATE mapping.estimate
#define COVERAGE mapping.estimate.coverage
#define EDGE_WORD(index) grid_starts[index]  // behind those of the grids
#include "renderer/photons/hash_grid.glsl"
#include "renderer/photons/precomputed_irradiance.glsl"
#include "renderer/photons/radiance_estimate.glsl"

SplitSamplers light_samplers() { return SplitSamplers(mapping.light_samples, 0u); }
SplitSamplers gather_samplers() {
    return SplitSamplers(mapping.gather_rays, mapping.light_samples * SPLIT_PREPARED_SETS);
}

/// Name of the numbers of the point that the eye path with that key reached at that vertex.
uint gather_key(uint path_key, uint vertex) { return hash32(path_key ^ (0x9e3779b9u * (vertex + 1u))); }

/// Light of the maps that is scattered by `rough` (f_d).
struct MapEstimates {
    RadianceEstimate caustic, global;
};
/// None when `most_scatterings` is 0, and none of the global map where it is not wanted. `query.most_radius_m` is for
/// that map's disc. A loop, so that the estimate, most of the shader, stands in it once.
MapEstimates estimate_maps(ShadingPoint surface, Bsdf rough, vec3 wo, uint most_scatterings, bool global_wanted,
                           DiscQuery query) {
    MapEstimates found = MapEstimates(no_radiance(), no_radiance());
    if (most_scatterings == 0) return found;
    const float most_radius_m = query.most_radius_m;
    for (uint kind = PHOTON_MAP_GLOBAL; kind <= PHOTON_MAP_CAUSTIC; ++kind) {
        const bool global = kind == PHOTON_MAP_GLOBAL;
        if (global ? !(GLOBAL_MAP && global_wanted) : !CAUSTIC_MAP) continue;
        query.most_radius_m = global ? most_radius_m : INFINITY;
        const RadianceEstimate estimate = estimate_radiance(kind, surface, rough, wo, most_scatterings, query);
        if (global)
            found.global = estimate;
        else
            found.caustic = estimate;
    }
    return found;
}

/// The same at the end of a gather ray: of the global map from the precomputed irradiance where that fits.
MapEstimates estimate_maps_at_end(ShadingPoint surface, Bsdf rough, vec3 wo, uint most_scatterings, DiscQuery query) {
    RadianceEstimate at_hand = no_radiance();
    bool is_at_hand = false;
    float weight = 1.0;
    // Irradiance was summed for one number of scatterings; a gather ray that followed specular surfaces has fewer left.
    if (PRECOMPUTED_IRRADIANCE && GLOBAL_MAP && mapping.irradiance_scatterings == most_scatterings &&
        !bsdf_has_non_delta_transmission(rough)) {
        IrradianceEstimate found;
        bool is_dark;
        const float search_radius_m = mapping.estimate.maps[PHOTON_MAP_GLOBAL].radius_m;
        if (find_irradiance(surface.position, surface.geometric_normal, found, is_dark)) {
            is_at_hand = true;
            at_hand = RadianceEstimate(bsdf_albedo(rough) * INV_PI * found.irradiance, vec3(0.0), 1u, 1u, found.radius_m);
        } else if (is_dark) {
            // A disc here is as large as discs get, costs the most and holds next to nothing: one of four is asked.
            is_at_hand = query.most_radius_m < search_radius_m || disc_lot(query.turn) >= DARK_DISC_SHARE;
            at_hand.radius_m = search_radius_m;
            weight = 1.0 / DARK_DISC_SHARE;
        }
    }
    MapEstimates maps = estimate_maps(surface, rough, wo, most_scatterings, !is_at_hand, query);
    maps.global.radiance *= weight;
    if (is_at_hand) maps.global = at_hand;
    return maps;
}

#endif

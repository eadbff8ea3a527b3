// GLSL twin of methods/photon_mapping/photon_lookup.h: the maps of a pass, and what all its threads share, in the
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
#include "renderer/methods/photon_mapping/split_samplers.glsl"
#include "renderer/eye/specular_walk.glsl"

layout(constant_id = FINAL_GATHER_ID) const bool FINAL_GATHER = false;
layout(constant_id = GLOBAL_MAP_ID) const bool GLOBAL_MAP = true;
layout(constant_id = CAUSTIC_MAP_ID) const bool CAUSTIC_MAP = true;

layout(set = 0, binding = MAPPING_BINDING, scalar) readonly buffer Mapping { PhotonMappingConstants mapping; };

#define ESTIMATE mapping.estimate
#define COVERAGE mapping.estimate.coverage
#define EDGE_CELL_WORD(index) grid_starts[index]  // behind those of the grids
#include "renderer/photons/hash_grid.glsl"
#include "renderer/photons/radiance_estimate.glsl"

SplitSamplers light_samplers() { return SplitSamplers(mapping.light_samples, 0u); }
SplitSamplers gather_samplers() {
    return SplitSamplers(mapping.gather_rays, mapping.light_samples * SPLIT_PREPARED_SETS);
}

/// Name of the numbers of the point that the eye path with that key reached at that vertex.
uint gather_key(uint path_key, uint vertex) { return hash32(path_key ^ (0x9e3779b9u * (vertex + 1u))); }

/// Scatterings left to a photon that is looked up after so many of the eye's path, the lookup's own included.
uint photon_scatterings_left(uint scatterings) {
    const uint most = eye.max_scatterings;
    return most == 0xffffffffu ? most : most - min(most, scatterings);
}

/// Light of the caustic map that is scattered by `rough` (f_d). None when `most_scatterings` is 0.
RadianceEstimate estimate_caustic(ShadingPoint surface, Bsdf rough, vec3 wo, uint most_scatterings, uint turn) {
    if (!CAUSTIC_MAP || most_scatterings == 0) return no_radiance();
    return estimate_radiance(PHOTON_MAP_CAUSTIC, surface, rough, wo, most_scatterings, turn);
}
/// The same of the global map.
RadianceEstimate estimate_global(ShadingPoint surface, Bsdf rough, vec3 wo, uint most_scatterings, uint turn) {
    if (!GLOBAL_MAP || most_scatterings == 0) return no_radiance();
    return estimate_radiance(PHOTON_MAP_GLOBAL, surface, rough, wo, most_scatterings, turn);
}

#endif

// GLSL twin of photons/caustic_photons.h's CausticMap: what a surface scatters of the light that specular scatterings
// alone brought to it. Define GRID_STARTS_BINDING, GRID_PLACES_BINDING, MAP_POWERS_BINDING, CAUSTIC_ESTIMATE_BINDING (of
// set 0) and NEAREST_GROUP (threads of the group) before.
#ifndef PHOTOND_CAUSTIC_LOOKUP_GLSL
#define PHOTOND_CAUSTIC_LOOKUP_GLSL

#include "renderer/photons/radiance_estimate_shared.h"

layout(set = 0, binding = CAUSTIC_ESTIMATE_BINDING, scalar) readonly buffer CausticEstimate {
    EstimateConstants caustic_estimate;
};
#define ESTIMATE caustic_estimate
#define COVERAGE ESTIMATE.coverage  // discs are whole: DISC_COVERAGE stays false
#define EDGE_WORD(index) 0u
#include "renderer/photons/radiance_estimate.glsl"

DiscQuery caustic_query() { return disc_query(0u, DISC_FINE_BATCH); }

/// Towards `wo`, by photons of at most so many scatterings.
vec3 caustic_radiance(ShadingPoint point, Bsdf rough, vec3 wo, uint most_scatterings) {
    if (most_scatterings == 0u) return vec3(0.0);
    return estimate_radiance(PHOTON_MAP_CAUSTIC, point, rough, wo, most_scatterings, caustic_query()).radiance;
}

/// Irradiance [W m^-2] of a Lambert reflector: `normal` is the one that shades.
vec3 caustic_irradiance(vec3 position, vec3 geometric_normal, vec3 normal, uint most_scatterings) {
    if (most_scatterings == 0u) return vec3(0.0);
    return estimate_irradiance(PHOTON_MAP_CAUSTIC, position, geometric_normal, normal, most_scatterings, caustic_query())
        .irradiance;
}

#endif

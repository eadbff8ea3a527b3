// GLSL twin of photons/precomputed_irradiance.h: the irradiance at a place from the marked photon that stands for it.
// What radiance_estimate.glsl wants is defined before.
#ifndef PHOTOND_PRECOMPUTED_IRRADIANCE_GLSL
#define PHOTOND_PRECOMPUTED_IRRADIANCE_GLSL

#include "renderer/photons/precomputed_irradiance_shared.h"
#include "renderer/photons/radiance_estimate.glsl"

layout(constant_id = PRECOMPUTED_IRRADIANCE_ID) const bool PRECOMPUTED_IRRADIANCE = false;

/// PrecomputedIrradiance::find(); false: nothing is found.
bool find_irradiance(vec3 position, vec3 normal, out IrradianceEstimate found, out bool is_dark) {
    is_dark = true;
    found = IrradianceEstimate(vec3(0.0), 0.0);
    const PhotonMapConstants map = ESTIMATE.maps[PHOTON_MAP_GLOBAL];
    float nearest_sq = sqr(map.radius_m);
    bool any = false;
    PlaceProbe probe = probe_place(position, normal, map.radius_m);
    // Cells are cut for searches of many photons: the nearest one is most often much nearer.
    const float begin = 0.5, step = 2.0;
    for (float radius_m = min(begin * map.grid.cell_m, map.radius_m);; radius_m = min(step * radius_m, map.radius_m)) {
        uint index;
        uvec4 point;
        float distance_sq;
        GridSearch search = grid_search(map.grid, position, radius_m);
        while (grid_next(map.grid, search, min(sqr(radius_m), nearest_sq), index, point, distance_sq)) {
            if (distance_sq >= nearest_sq || !photon_marked(point.w)) continue;
            if (dot(photon_normal(point.w), normal) < DISC_COSINE) continue;
            is_dark = false;
            const vec4 irradiance = uintBitsToFloat(map_powers[ESTIMATE.first_irradiance + index]);
            const vec3 photon = uintBitsToFloat(point.xyz);
            if (distance_sq > sqr(irradiance.w) ||
                abs(dot(photon - position, normal)) > disc_thickness_m(irradiance.w))
                continue;
            if (DISC_COVERAGE && !place_sees(probe, photon)) continue;
            nearest_sq = distance_sq;
            found = IrradianceEstimate(irradiance.xyz, irradiance.w);
            any = true;
        }
        if (any || radius_m >= map.radius_m) return any;
    }
}

#endif

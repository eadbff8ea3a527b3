#pragma once
// What the parameters of many lights come to, on both devices.

#include "renderer/many_lights/vpl_tracer.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/photons/caustic_photons.h"
#include "renderer/scene/scene.h"

namespace photond {

/// Whether further bounces are found by the voxel tree, which then knows its triangles.
inline bool traces_voxels(const SvoManyLightsParams& params) {
    return params.bounces > 1 && params.bounce_tracing == VplBounces::Voxels;
}

inline VplTracing tracing_of(const SvoManyLightsParams& params) {
    return {.vpls = params.vpls,
            .map_side = params.map_resolution,
            .bounces = params.bounces,
            .connect_threshold = params.connect_threshold,
            .sampler = params.sampler,
            .independent_paths = params.placement == VplPlacement::Metropolis};
}

/// How far from a point voxels stand in its light.
inline float voxel_reach_m(const SvoManyLightsParams& params, const Scene& scene) {
    constexpr float kShareOfScene = 0.4f;
    if (params.visibility != VplVisibility::NearField) return kInfinity;
    return params.near_field_radius_m.value_or(kShareOfScene * scene.bounds.radius());
}

/// Whether the light by narrow lobes is looked for, and there may be any.
inline bool asks_narrow_lobes(const SvoManyLightsParams& params, const Needs& needs) {
    return params.narrow_lobes && (needs.delta || needs.glossy || needs.transmission);
}

inline CausticSettings caustics_of(const SvoManyLightsParams& params) {
    return {.photons = params.caustic_photons,
            .most_scatterings = params.bounces,
            .glossy_threshold = params.caustic_threshold(),
            .sampler = params.sampler,
            .radius_m = params.caustic_radius_m};
}

/// Why there is no map of caustic photons; null: there is one, if the scene has light.
inline const char* why_no_caustics(const SvoManyLightsParams& params, bool specular_surfaces) {
    return !params.narrow_lobes            ? "narrow_lobes is off"
           : params.caustic_photons == 0   ? "caustic_photons is 0: they are path traced"
           : !specular_surfaces            ? "no specular surface"
           : params.max_scatterings() <= 1 ? "bounces is 0"
                                           : nullptr;
}

/// Whether there is one, as far as that is known before: narrow glossy lobes show in what was measured alone.
inline bool sends_caustics(const SvoManyLightsParams& params, const Workload& workload) {
    const bool specular = workload.needs.delta || (workload.photon_yield && workload.photon_yield->caustic.guided > 0);
    return !why_no_caustics(params, specular);
}

/// Whether depth maps tell of the shadows of direct light.
inline bool has_light_maps(const SvoManyLightsParams& params, const Needs& needs) {
    return params.direct == DirectShadows::ShadowMaps && needs.punctual_lights;
}

}  // namespace photond

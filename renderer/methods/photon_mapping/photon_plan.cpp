#include "renderer/methods/photon_mapping/photon_plan.h"

namespace photond {

PhotonPlan::PhotonPlan(const PhotonMappingParams& params, bool lights, bool specular_surfaces) {
    const uint32_t scatterings = params.max_scatterings();
    // `less` scatterings of a path are the eye's.
    const auto left = [&](uint32_t less) {
        return scatterings == UINT32_MAX ? UINT32_MAX : scatterings - std::min(scatterings, less);
    };
    const bool final = params.gather == Gather::Final;
    shadow = params.shadow_photons && lights;
    const char* nothing = !lights ? "the scene has no light" : left(1) == 0 ? "indirect_bounces is 0" : nullptr;
    if (nothing) {
        global.why_not = caustic.why_not = nothing;
        return;
    }
    if (specular_surfaces)
        caustic.most_scatterings = left(1);
    else
        caustic.why_not = "no specular surface";

    // Where gather rays begin, photons are asked for directions only.
    const bool asked_at_the_start = !final || params.gather_sampling == GatherSampling::Photons;
    global.most_scatterings = left(asked_at_the_start ? 1 : 2);
    if (!global.wanted()) global.why_not = "with one bounce only lights are asked for at the ends of gather rays";
    if (params.precompute_irradiance && final) irradiance_scatterings = left(2);
}

}  // namespace photond

#include "renderer/gathering/photon_plan.h"

#include "renderer/photons/photon_shared.h"

namespace photond {

namespace {

constexpr const char* kOneBounce = "with one bounce only lights are asked for at the ends of gather rays";

}  // namespace

PhotonPlan::PhotonPlan(const GatheringParams& params, uint64_t pixels, bool lights, bool specular_surfaces) {
    const uint32_t scatterings = params.max_scatterings();
    // `less` scatterings of a path are the eye's.
    const auto left = [&](uint32_t less) {
        return scatterings == UINT32_MAX ? UINT32_MAX : scatterings - std::min(scatterings, less);
    };
    const bool final = params.final_gather();
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
    if (!global.wanted()) global.why_not = kOneBounce;
    if (!params.precomputes_irradiance() || !final) return;
    // A disc at a photon costs about twice what one at a ray's end does, of which the few rays of a small image have
    // few.
    constexpr double kLeastRaysAMark = 2;
    const double marks = kExpectedPhotonYield.global.unguided * params.photons / PHOTONS_A_MARK;
    few_rays_ = static_cast<double>(pixels * params.splits(pixels).gather_rays) < kLeastRaysAMark * marks;
    if (!few_rays_) irradiance_scatterings = left(2);
}

PhotonPlan plan_of(const GatheringParams& params, const Workload& workload) {
    const bool lights = workload.lights > 0 || workload.environment_size.pixels() > 0;
    // Narrow glossy lobes show in what was measured alone.
    const bool specular = workload.needs.delta || (workload.photon_yield && workload.photon_yield->caustic.guided > 0);
    return {params, workload.film_size.pixels(), lights, specular};
}

const char* PhotonPlan::why_not_precomputed(const GatheringParams& params) const {
    if (!params.precomputes_irradiance() || irradiance_scatterings > 0) return nullptr;
    if (!params.final_gather()) return "it is for the ends of gather rays";
    if (!global.wanted()) return global.why_not.c_str();
    return few_rays_ ? "the gather rays are too few to be worth discs at photons" : kOneBounce;
}

}  // namespace photond

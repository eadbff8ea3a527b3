#pragma once
// Which photons a scene and the parameters ask for; what is not needed is not traced and not built.

#include <string>

#include "renderer/frame/render_context.h"
#include "renderer/gathering/expected_photons.h"
#include "renderer/gathering/gathering_params.h"
#include "renderer/photons/caustic_photons.h"

namespace photond {

struct PhotonPlan {
    /// One of the maps: the greatest number of scatterings of its photons, 0: no such map, and why.
    struct Map {
        uint32_t most_scatterings = 0;
        std::string why_not;
        bool wanted() const { return most_scatterings > 0; }
    };

    /// `pixels`: of the image.
    PhotonPlan(const GatheringParams& params, uint64_t pixels, bool lights, bool specular_surfaces);

    Map global, caustic;
    /// Of the irradiance that is precomputed for the ends of gather rays; 0: none.
    uint32_t irradiance_scatterings = 0;
    /// Why irradiance that the parameters ask for is not precomputed; nullptr: it is, or is not asked for.
    const char* why_not_precomputed(const GatheringParams& params) const;
    bool shadow = false;

private:
    bool few_rays_ = false;  // too few for irradiance to be precomputed
};

/// Of a scene as far as it is known before anything is loaded.
PhotonPlan plan_of(const GatheringParams& params, const Workload& workload);

}  // namespace photond

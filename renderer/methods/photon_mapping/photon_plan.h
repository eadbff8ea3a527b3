#pragma once
// Which photons a scene and the parameters ask for; what is not needed is not traced and not built.

#include <string>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/photons/caustic_photons.h"

namespace photond {

/// Of scenes in which nobody has measured it: the global map of a closed room with reflectances about a half (as in the
/// Cornell box), and the caustic map when specular surfaces fill a tenth.
inline constexpr PhotonYield kExpectedYield{.global = 0.905, .caustic = 0.1, .caustic_unguided = 0.1};

struct PhotonPlan {
    /// One of the maps: the greatest number of scatterings of its photons, 0: no such map, and why.
    struct Map {
        uint32_t most_scatterings = 0;
        std::string why_not;
        bool wanted() const { return most_scatterings > 0; }
    };

    PhotonPlan(const PhotonMappingParams& params, bool lights, bool specular_surfaces);

    Map global, caustic;
    /// Of the irradiance that is precomputed for the ends of gather rays; 0: none.
    uint32_t irradiance_scatterings = 0;
    bool shadow = false;
};

}  // namespace photond

#include "protocol/error.h"
#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"

namespace photond {

void ProbabilisticProgressivePhotonMappingParams::check() const {
    ProgressiveParams::check();
    if (!passes_stand_alone())
        throw Error(
            ErrorCode::Unsupported, "/radius_rule",
            "its passes stand alone, and radius_rule local and tested build on what passes before have counted");
}

}  // namespace photond

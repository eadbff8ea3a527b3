#include "renderer/methods/svo_many_lights/params.h"

#include "protocol/error.h"
#include "renderer/frame/common_params.h"

namespace photond {

void SvoManyLightsParams::check() const {
    require_power_of_two("/map_resolution", map_resolution);
    require_power_of_two("/voxel_resolution", voxel_resolution);
    require_power_of_two("/interleave", interleave);
    require_flux_placement(placement);
}

}  // namespace photond

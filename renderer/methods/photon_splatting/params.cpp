#include "renderer/methods/photon_splatting/params.h"

#include "protocol/error.h"

namespace photond {

void PhotonSplattingParams::check() const {
    if (splat_size_m && splat_size_relative)
        throw Error(ErrorCode::Conflict, "/splat_size_relative",
                    "splat_size and splat_size_relative exclude each other");
    // kMostBounces, the default, asks for as many as there can be.
    if (injection == PhotonInjection::ReflectiveShadowMap && bounces > 1 && bounces != kMostBounces)
        throw Error(ErrorCode::Conflict, "/bounces",
                    "bounces = " + std::to_string(bounces) +
                        " with injection reflective_shadow_map, which knows one bounce only");
    if (indirect_exposure != 1 && weighting != SplatWeighting::Normalised)
        throw Error(ErrorCode::Conflict, "/indirect_exposure",
                    "indirect_exposure scales the weighting normalised; radiometric has its scale");
}

}  // namespace photond

#include "renderer/gbuffer/upsampling.h"

#include "protocol/param_info.h"

namespace photond {

void visit_upsampling(ParamVisitor& visitor, uint32_t& subsampling, Upsampling& upsampling) {
    visitor.field("subsampling", subsampling,
                  {ParamGroup::Light, "", 1, 8,
                   "of each block of n x n pixels one is lit, the others take its indirect light; n is 1, 2, 4 or 8"});
    static constexpr std::string_view kUpsamplings[] = {"nearest", "bilinear", "normal", "geometry"};
    visitor.enumeration("upsampling", upsampling,
                        {ParamGroup::NoiseAndBias, kUpsamplings,
                         "how a pixel takes light from the lit ones about it: the nearest alone, by distance in the "
                         "image (bilinear), also by how normals agree, also by distance from the pixel's plane "
                         "(geometry)"});
}

}  // namespace photond

#pragma once
// The parameters of image-based lighting: each is a field here, and a line of visit().

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/methods/image_based_lighting/prefiltered_environment_shared.h"
#include "renderer/transport/sobol.h"

namespace photond {

struct ImageBasedLightingParams final : MethodParams {
    uint32_t bounces = 0;
    uint32_t prefilter_resolution = 256;
    uint32_t prefilter_levels = 12;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override { require_power_of_two("/prefilter_resolution", prefilter_resolution); }
};

inline void ImageBasedLightingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    visitor.field("bounces", bounces,
                  {Light, "", 0, 0, "greatest number of bounces in the indirect layer; it has none, which is black"});
    visitor.field("prefilter_resolution", prefilter_resolution,
                  {LightMaps, "", PREFILTER_LEAST_SIDE, 2048,
                   "cells along each side of the sharpest prefiltered map; a power of two"});
    visitor.field("prefilter_levels", prefilter_levels,
                  {LightMaps, "", 2, PREFILTER_MOST_LEVELS,
                   "maps by roughness, from the sharpest that the resolution allows to 1, each rougher by one factor"});
    visit_sampler(visitor, sampler);
}

}  // namespace photond

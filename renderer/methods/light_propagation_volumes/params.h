#pragma once
// The parameters of light propagation volumes: each is a field here, and a line of visit().

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/many_lights/vpl_params.h"
#include "renderer/methods/light_propagation_volumes/propagation_shared.h"
#include "renderer/transport/sobol.h"

namespace photond {

struct LightPropagationVolumesParams final : MethodParams {
    TemporalParams temporal;
    uint32_t vpls = 16384;
    uint32_t bounces = 254;
    uint32_t map_resolution = 128;
    uint32_t resolution = 16;
    uint32_t cascades = 1;
    uint32_t steps = 16;
    bool geometry_volume = true;
    bool receiver_rays = true;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override;
};

inline void LightPropagationVolumesParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    visitor.field("vpls", vpls, {Light, "lights", 1, 1e6, "virtual point lights that start in the volumes, a pass"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, 254, "greatest number of bounces in the indirect layer; 254: all"});
    visit_map_resolution(visitor, map_resolution);
    visitor.field("resolution", resolution, {Light, "cells", 8, 256, "of the volumes, along the scene's longest side"});
    visitor.field("cascades", cascades,
                  {Light, "volumes", 1, PROPAGATION_MOST_CASCADES,
                   "about what the camera looks at, each with cells of half the size of the one before"});
    visitor.field("steps", steps, {Light, "cells", 1, 1024, "that light goes on from where it starts"});
    visitor.flag("geometry_volume", geometry_volume,
                 {Visibility, "what lies between neighbouring cells stops light; without, it passes through walls"});
    visitor.flag(
        "receiver_rays", receiver_rays,
        {Visibility,
         "a point beside walls asks the cells about it by rays whether they see it; without, light of the next "
         "room leaks there"});
    visit_lit_glossy_threshold(visitor, glossy_threshold);
    visit_vpl_connect_threshold(visitor, connect_threshold);
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
}

}  // namespace photond

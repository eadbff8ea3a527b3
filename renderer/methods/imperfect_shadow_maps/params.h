#pragma once
// The parameters of imperfect shadow maps: each is a field here, and a line of visit().

#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/many_lights/path_selection.h"
#include "renderer/many_lights/vpl_params.h"
#include "renderer/transport/sobol.h"

namespace photond {

struct ImperfectShadowMapsParams final : MethodParams, WithIncrementalVpls {
    TemporalParams temporal;
    uint32_t vpls = 1024;
    uint32_t bounces = 1;
    uint32_t map_resolution = 128;
    VplPlacement placement = VplPlacement::Flux;
    uint32_t points = 8192;
    uint32_t shadow_resolution = 32;
    uint32_t interleave = 4;
    std::optional<float> clamp_m2;
    uint32_t filter = 0;
    float filter_normal = 0.9f;
    float filter_distance = 0.02f;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override;
};

inline void ImperfectShadowMapsParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    visitor.field("vpls", vpls, {Light, "lights", 1, 65536, "virtual point lights, a pass"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, 1, "greatest number of bounces in the indirect layer; it does no more than one"});
    visit_map_resolution(visitor, map_resolution);
    visit_vpl_placement(visitor, placement);
    visitor.field("points", points,
                  {Light, "points", 16, 65536, "of the scene, drawn into the depth map of each light"});
    visitor.field("shadow_resolution", shadow_resolution,
                  {Visibility, "texels", 4, 128, "along each side of a light's depth map"});
    visitor.field("interleave", interleave,
                  {Gathering, "pixels", 1, 8, "side of the blocks whose pixels share out the lights; a power of two"});
    visit_vpl_clamp(visitor, clamp_m2);
    visit_geometry_filter(visitor, filter, filter_normal, filter_distance);
    visit_lit_glossy_threshold(visitor, glossy_threshold);
    visit_vpl_connect_threshold(visitor, connect_threshold);
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
    incremental.visit(visitor);
}

}  // namespace photond

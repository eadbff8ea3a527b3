#pragma once
// The parameters of reflective shadow maps: each is a field here, and a line of visit().

#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/many_lights/vpl_params.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// Which texels of the lights' maps a pixel asks.
enum class RsmPattern : uint8_t {
    Flux,   // all pixels the same, by their flux
    Paper,  // each pixel those about its own place in the map
};

struct ReflectiveShadowMapsParams final : MethodParams, WithIncrementalVpls {
    TemporalParams temporal;
    uint32_t samples = 400;
    uint32_t bounces = 1;
    uint32_t map_resolution = 512;
    RsmPattern pattern = RsmPattern::Flux;
    float sample_radius = 0.3f;
    std::optional<float> clamp_m2;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override;
};

inline void ReflectiveShadowMapsParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kPatterns[] = {"flux", "paper"};
    visitor.field("samples", samples, {Light, "texels", 1, 65536, "of the lights' maps that light a pixel, a pass"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, 1, "greatest number of bounces in the indirect layer; it does no more than one"});
    visit_map_resolution(visitor, map_resolution);
    visitor.enumeration("pattern", pattern,
                        {Light, kPatterns,
                         "which texels light a pixel: for all the same, by flux; or those about the pixel's own place "
                         "in the map, as in the paper"});
    visitor.field(
        "sample_radius", sample_radius,
        {LightMaps, "", 1e-3, 1, "pattern paper: how far from the pixel's place, over the side of the light's map"});
    visitor.field("clamp", clamp_m2,
                  {NoiseAndBias, "m^2", 0, 1e18,
                   "a texel counts as if its squared distance were at least that; the lit area over pi times samples "
                   "when not given; 0: none, and at corners infinite variance"});
    visit_lit_glossy_threshold(visitor, glossy_threshold);
    visitor.field("connect_threshold", connect_threshold,
                  {NoiseAndBias, "", 0, 1, "texels: lobes with GGX alpha below it send nothing"});
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
    incremental.visit(visitor);
}

}  // namespace photond

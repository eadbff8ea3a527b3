#pragma once
// The parameters of voxel cone tracing: each is a field here, and a line of visit().

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/many_lights/vpl_params.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// Where diffuse cones go.
enum class ConeDirections : uint8_t { Drawn, Fixed };

/// How a cone looks at the cells about a step of it.
enum class ConeCells : uint8_t { Chance, All };

struct VoxelConeTracingParams final : MethodParams {
    TemporalParams temporal;
    uint32_t vpls = 32768;
    uint32_t bounces = 254;
    uint32_t map_resolution = 256;
    uint32_t voxel_resolution = 128;
    ConeDirections directions = ConeDirections::Drawn;
    float aperture_degrees = 15;
    float step = 0.5f;
    float start_voxels = 1;
    ConeCells cells = ConeCells::Chance;
    float gloss_aperture = 2;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override;
};

inline void VoxelConeTracingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kDirections[] = {"drawn", "fixed"};
    static constexpr std::string_view kCells[] = {"chance", "all"};
    visitor.field("vpls", vpls, {Light, "lights", 1, 1e6, "virtual point lights that light the voxels, a pass"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, 254, "greatest number of bounces in the indirect layer; 254: all"});
    visit_map_resolution(visitor, map_resolution);
    visitor.field("voxel_resolution", voxel_resolution,
                  {Visibility, "voxels", 16, 512, "along each side of the scene's cube; a power of two"});
    visitor.enumeration("directions", directions,
                        {Gathering, kDirections,
                         "the five cones of diffuse reflection are drawn anew by the cosine, each in its part of the "
                         "hemisphere; or one goes along the normal, four at 60 degrees from it"});
    visitor.field("aperture", aperture_degrees,
                  {Gathering, "degrees", 1, 120, "of the five cones of diffuse reflection, from side to side"});
    visitor.field("step", step, {Gathering, "", 0.05, 2, "of a cone, over its width there"});
    visitor.field("start", start_voxels,
                  {NoiseAndBias, "voxels", 0, 16, "how far from its surface a cone looks first"});
    visitor.enumeration("cells", cells,
                        {Gathering, kCells,
                         "a step of a cone looks at one of the sixteen cells about it, by chance; or at all of them, "
                         "which has the same mean, less noise and takes sixteen times as long"});
    visitor.field(
        "gloss_aperture", gloss_aperture,
        {Gathering, "", 0, 16, "of the cone of glossy reflection: its width over its length, over GGX alpha"});
    visit_lit_glossy_threshold(visitor, glossy_threshold);
    visit_vpl_connect_threshold(visitor, connect_threshold);
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
}

}  // namespace photond

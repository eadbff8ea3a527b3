#pragma once
// The parameters of many lights with a sparse voxel octree: each is a field here, and a line of visit().

#include <algorithm>
#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/many_lights/path_selection.h"
#include "renderer/many_lights/vpl_lighting.h"
#include "renderer/many_lights/vpl_params.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class VplChoice : uint8_t { Interleaved, Lightcut, Resampled };
enum class VplBounces : uint8_t { Voxels, Rays };
enum class DirectShadows : uint8_t { Rays, ShadowMaps };

struct SvoManyLightsParams final : MethodParams, WithIncrementalVpls {
    TemporalParams temporal;
    uint32_t vpls = 1024;
    uint32_t bounces = 254;
    uint32_t map_resolution = 128;
    VplPlacement placement = VplPlacement::Flux;
    VplBounces bounce_tracing = VplBounces::Rays;
    VplVisibility visibility = VplVisibility::Rays;
    std::optional<float> near_field_radius_m;
    uint32_t voxel_resolution = 256;
    uint32_t shadow_resolution = 32;
    VplChoice vpl_choice = VplChoice::Resampled;
    uint32_t interleave = 4;
    uint32_t cut_size = 64;
    uint32_t resampled_vpls = 8;
    float roulette = 0.1f;
    std::optional<float> clamp_m2;
    bool repay = true;
    bool narrow_lobes = true;
    uint32_t caustic_photons = 100'000;
    std::optional<float> caustic_radius_m;
    uint32_t filter = 0;
    float filter_normal = 0.9f;
    float filter_distance = 0.02f;
    DirectShadows direct = DirectShadows::Rays;
    uint32_t direct_resolution = 1024;
    uint32_t pcf = 3;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override;

    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return bounces + 1; }
    bool needs_voxels(const LayerSet& layers) const {
        return layers.has(Layer::Voxels) || asks_voxels(visibility) ||
               (bounces > 1 && bounce_tracing == VplBounces::Voxels);
    }
    /// GGX alpha of lobes below which light through them alone is the caustic map's: such connect in no case.
    float caustic_threshold() const { return std::min(glossy_threshold, connect_threshold); }
    /// Pixels along a side of the blocks whose pixels share out the lights.
    uint32_t split_side() const { return vpl_choice == VplChoice::Interleaved ? interleave : 1; }
};

inline void SvoManyLightsParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kBounceTracings[] = {"voxels", "rays"};
    static constexpr std::string_view kVisibilities[] = {"svo", "rays", "shadow_maps", "none", "near_field"};
    static constexpr std::string_view kChoices[] = {"interleaved", "lightcut", "resampled"};
    static constexpr std::string_view kDirect[] = {"rays", "shadow_maps"};

    visitor.field("vpls", vpls, {Light, "lights", 1, 1e6, "virtual point lights of the first bounce, a pass"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, 254, "greatest number of bounces in the indirect layer; 254: all"});
    visit_map_resolution(visitor, map_resolution);
    visit_vpl_placement(visitor, placement);
    visitor.enumeration("bounce_tracing", bounce_tracing,
                        {LightMaps, kBounceTracings,
                         "who finds the surfaces of further bounces: the voxels, which are off by about one, or rays"});
    visitor.enumeration("visibility", visibility,
                        {Light, kVisibilities,
                         "who answers whether a light is seen: the voxels between, the scene, a depth map of each "
                         "light, nobody: all are, or the voxels near the point alone, which lets light through what "
                         "is farther and is biased by that"});
    visitor.field(
        "near_field_radius", near_field_radius_m,
        {Visibility, "m", 0, 1e9,
         "visibility near_field: voxels farther from the lit point do not stand in its light; two fifths of the "
         "radius of the scene's bounding sphere when not given"});
    visitor.field("voxel_resolution", voxel_resolution,
                  {Visibility, "voxels", 16, 1024, "along each side of the scene's cube; a power of two"});
    visitor.field("shadow_resolution", shadow_resolution,
                  {Visibility, "texels", 4, 128, "visibility shadow_maps: along each side of a light's depth map"});
    visitor.enumeration("vpl_choice", vpl_choice,
                        {Light, kChoices,
                         "which lights a pixel asks: those of its place in a block of pixels; some for each of its cut "
                         "through a tree of all; or some of all, drawn by what they would bring unshadowed"});
    visitor.field("interleave", interleave,
                  {Gathering, "pixels", 1, 8, "interleaved: side of the blocks whose pixels share out the lights"});
    visitor.field("cut_size", cut_size, {Gathering, "lights", 1, 1024, "lightcut: asked by a pixel"});
    visitor.field("resampled_vpls", resampled_vpls, {Gathering, "lights", 1, 1024, "resampled: asked by a pixel"});
    visitor.field("roulette", roulette,
                  {Gathering, "", 0, 10,
                   "a light dimmer than that share of the mean of those a pixel looks at is asked by chance, and "
                   "counts for more; 0 asks all"});
    visit_vpl_clamp(visitor, clamp_m2);
    visitor.flag("repay", repay, {NoiseAndBias, "what the clamp takes is found by one short ray a pixel"});
    visitor.flag("narrow_lobes", narrow_lobes,
                 {NoiseAndBias,
                  "light that lobes below connect_threshold send to visible points is path traced by that ray, which "
                  "has no end then, and caustics are looked up; without, both are left out"});
    visitor.field(
        "caustic_photons", caustic_photons,
        {Light, "photons", 0, 1e9,
         "light paths a pass for the caustic map, with narrow_lobes; 0: caustics are path traced too, without "
         "bias and with bright dots"});
    visitor.field("caustic_radius", caustic_radius_m,
                  {DensityEstimate, "m", 1e-9, 1e9,
                   "radius of the caustic map's lookups in the first pass, from which it shrinks; by a pilot's photons "
                   "when not given"});
    visit_geometry_filter(visitor, filter, filter_normal, filter_distance);
    visitor.enumeration("direct", direct,
                        {LightMaps, kDirect,
                         "shadows of point, spot and directional lights: by rays, or by shadow maps with "
                         "percentage-closer filtering; other lights' always by rays"});
    visitor.field("direct_resolution", direct_resolution, {LightMaps, "texels", 16, 8192, "side of those shadow maps"});
    visitor.field("pcf", pcf, {LightMaps, "texels", 1, 15, "side of the percentage-closer filter"});
    visit_lit_glossy_threshold(visitor, glossy_threshold);
    visit_vpl_connect_threshold(visitor, connect_threshold);
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
    incremental.visit(visitor);
}

}  // namespace photond

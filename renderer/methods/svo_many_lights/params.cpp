#include "protocol/error.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"

namespace photond {

void SvoManyLightsParams::visit(ParamVisitor& visitor) {
    static constexpr std::string_view kPlacements[] = {"flux", "camera"};
    static constexpr std::string_view kBounceTracings[] = {"voxels", "rays"};
    static constexpr std::string_view kVisibilities[] = {"svo", "rays", "shadow_maps", "none"};
    static constexpr std::string_view kChoices[] = {"interleaved", "lightcut", "resampled"};
    static constexpr std::string_view kDirect[] = {"rays", "shadow_maps"};
    static constexpr std::string_view kSamplers[] = {"sobol", "random"};

    visitor.field("vpls", vpls, {"lights", 1, 1e6, "virtual point lights of the first bounce, a pass"});
    visitor.field("bounces", bounces, {"", 0, 254, "greatest number of bounces in the indirect layer"});
    visitor.field("map_resolution", map_resolution,
                  {"texels", 8, 1024, "side of the reflective shadow maps, all lights' together; a power of two"});
    visitor.enumeration("placement", placement,
                        {kPlacements, "lights go where flux is, or where what they bring to the picture is"});
    visitor.enumeration("bounce_tracing", bounce_tracing,
                        {kBounceTracings,
                         "who finds the surfaces of further bounces: the voxels, which are off by about one, or rays"});
    visitor.enumeration("visibility", visibility,
                        {kVisibilities,
                         "who answers whether a light is seen: the voxels between, the scene, a depth map of each "
                         "light, or nobody: all are"});
    visitor.field("voxel_resolution", voxel_resolution,
                  {"voxels", 16, 1024, "along each side of the scene's cube; a power of two"});
    visitor.field("shadow_resolution", shadow_resolution,
                  {"texels", 4, 128, "visibility shadow_maps: along each side of a light's depth map"});
    visitor.enumeration("vpl_choice", vpl_choice,
                        {kChoices,
                         "which lights a pixel asks: those of its place in a block of pixels; some for each of its cut "
                         "through a tree of all; or some of all, drawn by what they would bring unshadowed"});
    visitor.field("interleave", interleave,
                  {"pixels", 1, 8, "interleaved: side of the blocks whose pixels share out the lights"});
    visitor.field("cut_size", cut_size, {"lights", 1, 1024, "lightcut: asked by a pixel"});
    visitor.field("resampled_vpls", resampled_vpls, {"lights", 1, 1024, "resampled: asked by a pixel"});
    visitor.field("roulette", roulette,
                  {"", 0, 10,
                   "a light dimmer than that share of the mean of those a pixel looks at is asked by chance, and "
                   "counts for more; 0 asks all"});
    visitor.field("clamp", clamp_m2,
                  {"m^2", 0, 1e18,
                   "a connection counts as if its squared length were at least that; the lit area over pi times "
                   "vpls when not given; 0: none, and at corners infinite variance"});
    visitor.flag("repay", repay, "what the clamp takes is found by one short ray a pixel");
    visitor.flag("narrow_lobes", narrow_lobes,
                 "light that lobes below connect_threshold send to visible points, caustics among it, is path traced "
                 "by that ray, which has no end then; without, it is left out");
    visitor.field("filter", filter,
                  {"pixels", 0, 17,
                   "side of the geometry-aware box filter over indirect light, which takes out the blocks' pattern and "
                   "blurs; 0: none"});
    visitor.field("filter_normal", filter_normal, {"", -1, 1, "filter: least cosine between the normals"});
    visitor.field("filter_distance", filter_distance,
                  {"", 0, 1e3, "filter: greatest distance from the pixel's plane, over its depth"});
    visitor.enumeration("direct", direct,
                        {kDirect,
                         "shadows of point, spot and directional lights: by rays, or by shadow maps with "
                         "percentage-closer filtering; other lights' always by rays"});
    visitor.field("direct_resolution", direct_resolution, {"texels", 16, 8192, "side of those shadow maps"});
    visitor.field("pcf", pcf, {"texels", 1, 15, "side of the percentage-closer filter"});
    visitor.field("glossy_threshold", glossy_threshold,
                  {"", 0, 1, "eye paths: lobes with GGX alpha below it are followed, not lit"});
    visitor.field("connect_threshold", connect_threshold,
                  {"", 0, 1, "lights: lobes with GGX alpha below it send nothing"});
    visitor.enumeration("sampler", sampler,
                        {kSamplers, "numbers of the passes: low-discrepancy (Owen-scrambled Sobol') or independent"});
}

void SvoManyLightsParams::check() const {
    const auto power_of_two = [](const char* pointer, uint32_t value) {
        if ((value & (value - 1)) != 0)
            throw Error(ErrorCode::OutOfRange, pointer,
                        std::string(pointer + 1) + " = " + std::to_string(value) + " is no power of two");
    };
    power_of_two("/map_resolution", map_resolution);
    power_of_two("/voxel_resolution", voxel_resolution);
    power_of_two("/interleave", interleave);
}

}  // namespace photond

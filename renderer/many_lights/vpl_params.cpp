#include "renderer/many_lights/vpl_params.h"

#include "protocol/error.h"
#include "protocol/param_info.h"
#include "renderer/many_lights/path_selection.h"

namespace photond {

void IncrementalVplParams::visit(ParamVisitor& visitor) {
    visitor.flag("incremental", on,
                 {ParamGroup::Frames,
                  "the lights of the frame before stay as long as its lamps see them; each counts as much as the flux "
                  "about it, so that what is between them is guessed: a bias, the same from frame to frame"});
    visitor.field("new_vpls", new_vpls,
                  {ParamGroup::Frames, "lights", 1, 1e6,
                   "incremental: most new lights of a frame, where the frame before left any"});
}

void WithIncrementalVpls::require_flux_placement(VplPlacement placement) const {
    if (incremental.on && placement != VplPlacement::Flux)
        throw Error(ErrorCode::OutOfRange, "/incremental", "incremental goes with placement flux alone");
}

void visit_map_resolution(ParamVisitor& visitor, uint32_t& resolution) {
    visitor.field("map_resolution", resolution,
                  {ParamGroup::LightMaps, "texels", 8, 1024,
                   "side of the reflective shadow maps, all lights' together; a power of two"});
}

void visit_vpl_placement(ParamVisitor& visitor, VplPlacement& placement) {
    static constexpr std::string_view kWords[] = {"flux", "camera", "acceptance", "metropolis"};
    visitor.enumeration("placement", placement,
                        {ParamGroup::Light, kWords,
                         "lights go where flux is, where flux is that the picture sees, or by what whole light paths "
                         "bring to the picture, shadows among it: candidates are accepted by that, or chains go "
                         "through the paths; none is biased"});
}

void visit_vpl_clamp(ParamVisitor& visitor, std::optional<float>& clamp_m2) {
    visitor.field("clamp", clamp_m2,
                  {ParamGroup::NoiseAndBias, "m^2", 0, 1e18,
                   "a connection counts as if its squared length were at least that; the lit area over pi times vpls "
                   "when not given; 0: none, and at corners infinite variance"});
}

void visit_geometry_filter(ParamVisitor& visitor, uint32_t& side, float& normal, float& distance) {
    using enum ParamGroup;
    visitor.field("filter", side,
                  {Filter, "pixels", 0, 17,
                   "side of the geometry-aware box filter over indirect light, which takes out the blocks' pattern and "
                   "blurs; 0: none"});
    visitor.field("filter_normal", normal, {Filter, "", -1, 1, "filter: least cosine between the normals"});
    visitor.field("filter_distance", distance,
                  {Filter, "", 0, 1e3, "filter: greatest distance from the pixel's plane, over its depth"});
}

void visit_lit_glossy_threshold(ParamVisitor& visitor, float& threshold) {
    visitor.field(
        "glossy_threshold", threshold,
        {ParamGroup::NoiseAndBias, "", 0, 1, "eye paths: lobes with GGX alpha below it are followed, not lit"});
}

void visit_vpl_connect_threshold(ParamVisitor& visitor, float& threshold) {
    visitor.field("connect_threshold", threshold,
                  {ParamGroup::NoiseAndBias, "", 0, 1, "lights: lobes with GGX alpha below it send nothing"});
}

}  // namespace photond

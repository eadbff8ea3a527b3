#include "renderer/photons/photon_params.h"

#include "protocol/error.h"
#include "protocol/param_info.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/kernel.h"

namespace photond {

using enum ParamGroup;

void visit_map_photons(ParamVisitor& visitor, uint32_t& photons, std::optional<uint32_t>& caustic_photons) {
    visitor.field("photons", photons, {Light, "photons", 1, 1e9, "light paths a pass, for the global map"});
    visitor.field("caustic_photons", caustic_photons,
                  {Light, "photons", 1, 1e9, "light paths a pass, for the caustic map; as photons when not given"});
}

void visit_photon_bounces(ParamVisitor& visitor, std::optional<uint32_t>& bounces) {
    visitor.field("indirect_bounces", bounces,
                  {Light, "", 0, 254, "greatest number of bounces in the indirect layer; unlimited when not given"});
}

void visit_kernel(ParamVisitor& visitor, KernelShape& kernel, float& cone_k) {
    static constexpr std::string_view kKernels[] = {"constant", "cone", "gaussian", "epanechnikov"};
    visitor.enumeration("kernel", kernel, {DensityEstimate, kKernels, "weight of a photon by its distance"});
    visitor.field("cone_k", cone_k,
                  {DensityEstimate, "", 1, 1e6, "of the cone kernel: it falls to 1 - 1/k at the rim"});
}

void visit_disc_thickness(ParamVisitor& visitor, std::optional<float>& thickness_m) {
    visitor.field("disc_thickness", thickness_m,
                  {DensityEstimate, "m", 1e-9, 1e9,
                   "photons farther from the tangent plane are refused; a quarter of the disc's radius "
                   "when not given"});
}

void visit_disc_boundary(ParamVisitor& visitor, DiscBoundary& boundary) {
    static constexpr std::string_view kBoundaries[] = {"none", "clip"};
    visitor.enumeration(
        "boundary", boundary,
        {DensityEstimate, kBoundaries,
         "clip: divide by the part of the disc that lies on surface which light can reach, and let none leak through "
         "walls; none: by the whole disc, which loses up to a sixth of the indirect light in furnished places"});
}

void visit_projection_maps(ParamVisitor& visitor, bool& projection_maps) {
    visitor.flag("projection_maps", projection_maps,
                 {LightMaps,
                  "send caustic photons where the lights see specular surfaces, and others where they see any surface, "
                  "where that doubles how many meet one"});
}

void visit_photon_glossy_threshold(ParamVisitor& visitor, float& threshold) {
    visitor.field("glossy_threshold", threshold,
                  {NoiseAndBias, "", 0, 1, "lobes with GGX alpha below it are specular: followed, not looked up"});
}

void require_one_radius(const std::optional<float>& radius_m, const std::optional<float>& radius_relative) {
    if (radius_m && radius_relative)
        throw Error(ErrorCode::Conflict, "/radius_relative", "radius and radius_relative exclude each other");
}

}  // namespace photond

#include "renderer/methods/image_space_photon_mapping/params.h"

#include "protocol/error.h"

namespace photond {

namespace {

constexpr float kRadiusRelative = 0.03f;

}  // namespace

void ImageSpacePhotonMappingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    visit_map_photons(visitor, photons, caustic_photons);
    static constexpr std::string_view kTraces[] = {"gpu", "cpu"};
    visitor.enumeration("trace", trace,
                        {Light, kTraces,
                         "where photons are traced: on the device (gpu), or on the host's cores while the device draws "
                         "those of the pass before (cpu): the same light, in another time"});
    visitor.field("bounce_map_texels", bounce_map_texels,
                  {Light, "", 1, 1e8,
                   "places where light first arrives that a pass's photons leave from together, but caustic ones: rays "
                   "saved, for photons that are less apart; when not given each photon traces its own way from the "
                   "light"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, 254,
                   "greatest number of bounces in the indirect layer; as many as there are when not "
                   "given"});
    static constexpr std::string_view kFootprints[] = {"quad", "volume", "auto"};
    visitor.enumeration("footprint", footprint,
                        {DensityEstimate, kFootprints,
                         "what a photon lights: what lies near the plane of its surface (quad), or what lies within a "
                         "flattened ball about it (volume), which reaches round corners; auto is both together"});
    visitor.field("volume_height", volume_height,
                  {DensityEstimate, "", 0.05, 1, "half the height of volumes over their radius; 1 is a whole ball"});
    static constexpr std::string_view kScatters[] = {"tiles", "raster"};
    visitor.enumeration("scatter", scatter,
                        {DensityEstimate, kScatters,
                         "how the pixels are found that a photon lights: each block of pixels goes through the photons "
                         "that may reach it (tiles), or photons are drawn over the pixels (raster), but for those in "
                         "mirrors, out of focus, near edges or not Lambert: the same light, in another time"});
    visitor.field("radius", radius_m, {DensityEstimate, "m", 1e-9, 1e9, "of a photon's footprint in the first pass"});
    visitor.field("radius_relative", radius_relative,
                  {DensityEstimate, "", 1e-9, 1e3,
                   "the same, over the radius of the scene's bounding sphere; 0.03 when neither is given"});
    visitor.field("caustic_radius_share", caustic_radius_share,
                  {DensityEstimate, "", 0.01, 1,
                   "radius of caustic photons' footprints, over that of the others: their paths lie denser"});
    visitor.flag("shrink", shrink,
                 {DensityEstimate, "footprints shrink from pass to pass, so that the mean of the passes converges"});
    visitor.field(
        "alpha", alpha,
        {DensityEstimate, "", 0.01, 1,
         "share of the photons in a footprint that the next pass keeps, where they shrink: squared bias falls "
         "as the passes' number to the power 2 alpha - 2"});
    visit_upsampling(visitor, subsampling, upsampling);
    static constexpr std::string_view kSoftShadows[] = {"gather", "fixed_radius", "rays", "none"};
    visitor.enumeration("soft_shadow", soft_shadow,
                        {NoiseAndBias, kSoftShadows,
                         "shadows of lights that are not points: rays to another point of the light in each pass "
                         "(rays), a ray to its middle (none), or that and a blur in the image, by how far off what "
                         "hides it is (gather) or as if that were half way to the light (fixed_radius)"});
    visitor.field("shadow_search_samples", shadow_search_samples,
                  {Light, "", 1, 64, "n: of n x n pixels a shadow's width is found from, by soft_shadow gather"});
    visitor.field("shadow_blur_samples", shadow_blur_samples,
                  {Light, "", 1, 64, "n: of n x n pixels that a soft shadow is the mean of"});
    visitor.flag("one_pass", one_pass,
                 {Light,
                  "upsampling, soft shadows and their sum are one step on the device; else three: the same "
                  "image, in another time"});
    visit_kernel(visitor, kernel, cone_k);
    visit_disc_boundary(visitor, boundary);
    visit_projection_maps(visitor, projection_maps);
    visit_photon_glossy_threshold(visitor, glossy_threshold);
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
}

void ImageSpacePhotonMappingParams::check() const {
    require_one_radius(radius_m, radius_relative);
    require_power_of_two("/subsampling", subsampling);
    if (bounce_map_texels && trace == PhotonTrace::Cpu)
        throw Error(ErrorCode::Conflict, "/bounce_map_texels",
                    "the bounce map is the device's, and photons that leave from it are traced there: it needs trace "
                    "'gpu'");
    if (bounce_map_texels && *bounce_map_texels > photons)
        throw Error(ErrorCode::OutOfRange, "/bounce_map_texels",
                    "must be at most photons, " + std::to_string(photons) + ", which leave from them");
}

float ImageSpacePhotonMappingParams::radius_of_pass_m(uint32_t pass, float scene_radius_m) const {
    const float first_m = radius_m.value_or(radius_relative.value_or(kRadiusRelative) * scene_radius_m);
    return shrink ? first_m * radius_share(pass, double{alpha}) : first_m;
}

}  // namespace photond

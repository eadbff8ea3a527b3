#pragma once
// The parameters of photon mapping: each is a field here, and a line of visit().

#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/photons/photon_map.h"
#include "renderer/photons/radiance_estimate.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class Gather : uint8_t { Direct, Final };
enum class GatherSampling : uint8_t { Bsdf, Photons };
enum class DiscBoundary : uint8_t { None, Clip };

/// Paths that one from the eye goes on as at a vertex the eye sees directly.
struct Splits {
    uint32_t light_samples;
    uint32_t gather_rays;  // 0: light is not gathered
};

struct PhotonMappingParams final : MethodParams {
    uint32_t photons = 200'000;
    std::optional<uint32_t> caustic_photons;
    std::optional<uint32_t> indirect_bounces;
    Gather gather = Gather::Final;
    std::optional<uint32_t> gather_rays;
    std::optional<uint32_t> light_samples;
    GatherSampling gather_sampling = GatherSampling::Bsdf;
    bool precompute_irradiance = false;
    bool shadow_photons = false;
    PhotonSearch::Kind search = PhotonSearch::Kind::Nearest;
    uint32_t nearest_photons = 50;
    std::optional<uint32_t> caustic_nearest_photons;
    std::optional<float> radius_m;
    std::optional<float> radius_relative;
    KernelShape kernel = KernelShape::Constant;
    float cone_k = 1.1f;
    std::optional<float> disc_thickness_m;
    bool soft_disc = false;
    DiscBoundary boundary = DiscBoundary::Clip;
    bool projection_maps = true;
    float glossy_threshold = 0.05f;
    SamplerKind sampler = SamplerKind::Sobol;
    bool keep_photon_map = false;

    void visit(ParamVisitor& visitor) override;
    /// `radius` and `radius_relative` exclude each other.
    void check() const override;

    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return indirect_bounces ? *indirect_bounces + 1 : UINT32_MAX; }
    /// For an image of so many pixels. Where the gather rays are not given, a pass has about as many in all, whatever
    /// the image's size.
    Splits splits(uint64_t pixels) const;
    /// Of the maps, for a scene whose bounding sphere has that radius.
    float search_radius_m(float scene_radius_m) const;
    /// Of the search among shadow photons: the radius where one is given, else that of a fixed search.
    float shadow_radius_m(float scene_radius_m) const;
};

inline void PhotonMappingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kGathers[] = {"direct", "final"};
    static constexpr std::string_view kGatherSamplings[] = {"bsdf", "photons"};
    static constexpr std::string_view kSearches[] = {"nearest", "radius"};
    static constexpr std::string_view kKernels[] = {"constant", "cone", "gaussian", "epanechnikov"};
    static constexpr std::string_view kBoundaries[] = {"none", "clip"};

    visitor.field("photons", photons, {Light, "photons", 1, 1e9, "light paths a pass, for the global map"});
    visitor.field("caustic_photons", caustic_photons,
                  {Light, "photons", 1, 1e9, "light paths a pass, for the caustic map; as photons when not given"});
    visitor.field("indirect_bounces", indirect_bounces,
                  {Light, "", 0, 254,
                   "greatest number of bounces in the indirect layer; unlimited when not "
                   "given"});
    visitor.enumeration("gather", gather,
                        {Light, kGathers,
                         "diffuse interreflection by looking the global map up where the eye sees (direct) or at the "
                         "ends of gather rays (final)"});
    visitor.field("gather_rays", gather_rays,
                  {Light, "rays", 1, 4096,
                   "of a final gather at a vertex the eye sees directly; fewer rays make shorter passes, and the mean "
                   "of the passes is the same; when not given 8, in images of over 131072 pixels 1048576 in all"});
    visitor.field("light_samples", light_samples,
                  {Gathering, "samples", 1, 1024,
                   "light samples at a vertex the eye sees directly; when not given a quarter of the gather rays for "
                   "final gathering, one otherwise"});
    visitor.enumeration("gather_sampling", gather_sampling,
                        {Gathering, kGatherSamplings,
                         "directions of gather rays: by the BSDF alone, or half of them by where the "
                         "photons about the point came from"});
    visitor.flag("precompute_irradiance", precompute_irradiance,
                 {Gathering,
                  "final gather: irradiance is worked out at every fourth photon beforehand, and the nearest is taken; "
                  "faster, and surfaces at the ends of gather rays count as Lambert reflectors"});
    visitor.flag(
        "shadow_photons", shadow_photons,
        {Gathering,
         "leave out shadow rays where all photons about a point say that a light is seen whole, or not at all"});
    visitor.enumeration("search", search,
                        {DensityEstimate, kSearches,
                         "photons of an estimate: the k nearest (kd-tree) or all within a radius (hash "
                         "grid)"});
    visitor.field("nearest_photons", nearest_photons,
                  {DensityEstimate, "photons", 2, 100'000, "k of a nearest search"});
    visitor.field("caustic_nearest_photons", caustic_nearest_photons,
                  {DensityEstimate, "photons", 2, 100'000, "k in the caustic map; as nearest_photons when not given"});
    visitor.field(
        "radius", radius_m,
        {DensityEstimate, "m", 1e-9, 1e9, "radius of the disc; of a nearest search the farthest that is looked at"});
    visitor.field("radius_relative", radius_relative,
                  {DensityEstimate, "", 1e-9, 1e3,
                   "the same, over the radius of the scene's bounding sphere; 0.03 for search radius and "
                   "0.05 for search nearest when neither is given"});
    visitor.enumeration("kernel", kernel, {DensityEstimate, kKernels, "weight of a photon by its distance"});
    visitor.field("cone_k", cone_k,
                  {DensityEstimate, "", 1, 1e6, "of the cone kernel: it falls to 1 - 1/k at the rim"});
    visitor.field("disc_thickness", disc_thickness_m,
                  {DensityEstimate, "m", 1e-9, 1e9,
                   "photons farther from the tangent plane are refused; a quarter of the disc's radius "
                   "when not given"});
    visitor.flag("soft_disc", soft_disc,
                 {DensityEstimate,
                  "weight photons by normal and distance from the plane instead of refusing them; loses energy"});
    visitor.enumeration(
        "boundary", boundary,
        {DensityEstimate, kBoundaries,
         "clip: divide by the part of the disc that lies on surface which light can reach, and let none leak through "
         "walls; none: by the whole disc, which loses up to a sixth of the indirect light in furnished places"});
    visitor.flag("projection_maps", projection_maps,
                 {LightMaps, "send caustic photons where the lights see specular surfaces"});
    visitor.field("glossy_threshold", glossy_threshold,
                  {NoiseAndBias, "", 0, 1, "lobes with GGX alpha below it are specular: followed, not looked up"});
    visit_sampler(visitor, sampler);
    visitor.flag("keep_photon_map", keep_photon_map, {Files, "leave the last pass's photons as a file"});
}

}  // namespace photond

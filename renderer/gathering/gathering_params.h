#pragma once
// The parameters of methods that gather light from photon maps: each is a field here, and a line of a visit.

#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/photons/photon_map.h"
#include "renderer/photons/photon_params.h"
#include "renderer/photons/radiance_estimate.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class GatherSampling : uint8_t { Bsdf, Photons };

/// Paths that one from the eye goes on as at a vertex the eye sees directly.
struct Splits {
    uint32_t light_samples;
    uint32_t gather_rays;  // 0: light is not gathered
};

/// What such methods have in common; each says what is its own.
struct GatheringParams : MethodParams {
    uint32_t photons = 200'000;
    std::optional<uint32_t> caustic_photons;
    std::optional<uint32_t> indirect_bounces;
    std::optional<uint32_t> gather_rays;
    std::optional<uint32_t> light_samples;
    GatherSampling gather_sampling = GatherSampling::Bsdf;
    bool shadow_photons = false;
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

    /// Whether diffuse interreflection is gathered by rays, or looked up where the eye sees.
    virtual bool final_gather() const = 0;
    /// How photons about a point are found.
    virtual PhotonSearch::Kind search_kind() const = 0;
    /// Whether irradiance for the ends of gather rays is worked out beforehand.
    virtual bool precomputes_irradiance() const = 0;

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

protected:
    void visit_light(ParamVisitor& visitor);
    void visit_rays(ParamVisitor& visitor);
    void visit_estimate(ParamVisitor& visitor);
};

inline void GatheringParams::visit_light(ParamVisitor& visitor) {
    visit_map_photons(visitor, photons, caustic_photons);
    visit_photon_bounces(visitor, indirect_bounces);
}

inline void GatheringParams::visit_rays(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kGatherSamplings[] = {"bsdf", "photons"};

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
    visitor.flag(
        "shadow_photons", shadow_photons,
        {Gathering,
         "leave out shadow rays where all photons about a point say that a light is seen whole, or not at all"});
}

inline void GatheringParams::visit_estimate(ParamVisitor& visitor) {
    using enum ParamGroup;
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
    visit_kernel(visitor, kernel, cone_k);
    visit_disc_thickness(visitor, disc_thickness_m);
    visitor.flag("soft_disc", soft_disc,
                 {DensityEstimate,
                  "weight photons by normal and distance from the plane instead of refusing them; loses energy"});
    visit_disc_boundary(visitor, boundary);
    visit_projection_maps(visitor, projection_maps);
    visit_photon_glossy_threshold(visitor, glossy_threshold);
    visit_sampler(visitor, sampler);
    visitor.flag("keep_photon_map", keep_photon_map, {Files, "leave the last pass's photons as a file"});
}

}  // namespace photond

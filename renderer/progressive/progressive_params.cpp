#include "renderer/progressive/progressive_params.h"

#include "protocol/error.h"
#include "renderer/frame/common_params.h"
#include "renderer/photons/photon_params.h"

namespace photond {

void ProgressiveParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kRules[] = {"global", "trained", "local", "tested"};
    static constexpr std::string_view kTests[] = {"radial", "sector"};

    visit_map_photons(visitor, photons, caustic_photons);
    visit_photon_bounces(visitor, indirect_bounces);
    visitor.enumeration(
        "radius_rule", radius_rule,
        {DensityEstimate, kRules,
         "how radii shrink: global, one for the scene by the pass's number; trained, one for each place, found by a "
         "pilot, by the pass's number; local, each pixel's own by the photons it has met; tested, each pixel's own "
         "where its photons say that light is curved. Passes of local and tested build on those before: their films "
         "cannot be merged"});
    visitor.field("alpha", alpha,
                  {DensityEstimate, "", 0.01, 0.99,
                   "share of the photons that is kept from pass to pass: noise falls as the passes' number to the "
                   "power -alpha, squared bias to the power 2 alpha - 2"});
    visitor.enumeration("test", test,
                        {DensityEstimate, kTests,
                         "of radius_rule tested: whether photons lie nearer to the centre or to the rim than in even "
                         "light (radial), or more in one part of the disc than in another (sector)"});
    visitor.field("nearest_photons", nearest_photons,
                  {DensityEstimate, "photons", 2, 100'000,
                   "of a pass: that the first radius is to hold, as a pilot finds it where no radius is given; of "
                   "radius_rule trained no matter"});
    visitor.field("radius", radius_m,
                  {DensityEstimate, "m", 1e-9, 1e9, "of the disc in the first pass; a pilot's when not given"});
    visitor.field("radius_relative", radius_relative,
                  {DensityEstimate, "", 1e-9, 1e3, "the same, over the radius of the scene's bounding sphere"});
    visit_kernel(visitor, kernel, cone_k);
    visit_disc_thickness(visitor, disc_thickness_m);
    visit_disc_boundary(visitor, boundary);
    visit_projection_maps(visitor, projection_maps);
    visit_photon_glossy_threshold(visitor, glossy_threshold);
    visit_sampler(visitor, sampler);
}

void ProgressiveParams::check() const {
    require_one_radius(radius_m, radius_relative);
    if (radius_rule == RadiusRule::Trained && (radius_m || radius_relative))
        throw Error(ErrorCode::Conflict, radius_m ? "/radius" : "/radius_relative",
                    "radius_rule trained finds the first radii itself; global, local and tested take one");
}

std::optional<float> ProgressiveParams::first_radius_m(float scene_radius_m) const {
    if (radius_m) return radius_m;
    // A scene without extent holds nothing to be found, but a search wants a radius.
    if (radius_relative) return std::max(*radius_relative * scene_radius_m, 1e-20f);
    return std::nullopt;
}

}  // namespace photond

#pragma once
#include "renderer/progressive/progressive_mapping.h"

namespace photond {

struct StochasticProgressivePhotonMappingParams final : ProgressiveParams {
    StochasticProgressivePhotonMappingParams() { radius_rule = RadiusRule::Local; }
};

/// Stochastic progressive photon mapping: new hit points in every pass, whose statistics a pixel shares.
///
/// Each pass draws one path of the eye a pixel (its place on the pixel and on the lens, and gloss that is followed), so
/// that depth of field, edges and glossy reflections converge; the pixel keeps one radius for all of its hit points in
/// each map, and what it has counted. What happens at them is said in progressive/progressive_mapping.h, how radii
/// shrink in progressive/disc_radii.h. By the rule `local`, as published, noise falls as N^-alpha and bias as
/// N^(alpha - 1) with the passes N.
///
/// Strong where light reaches matte surfaces by glass and mirrors and is seen through them, out of focus and in gloss.
/// Where a pixel sees near and far, or light and shadow, at once, one radius serves both. Passes build on those before
/// where `radius_rule` is local or tested: such films cannot be merged or cut;
/// probabilistic_progressive_photon_mapping has none of this. Biased at any time by the radii at hand (layer
/// `bias_estimate`); with `boundary` none by what discs lose near edges of surfaces.
/// Not implemented: participating media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// [Hachisuka and Jensen 2009] Stochastic Progressive Photon Mapping. ACM TOG 28(5).
class StochasticProgressivePhotonMapping final : public ProgressiveMapping {
public:
    static constexpr const char* kName = "stochastic_progressive_photon_mapping";
    using Params = StochasticProgressivePhotonMappingParams;

    explicit StochasticProgressivePhotonMapping(const Params& params)
        : ProgressiveMapping(std::make_unique<Params>(params), 0) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMapping::estimate_bytes(params, 0, workload);
    }
    static uint64_t estimate_state_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMapping::estimate_state_bytes(params, 0, workload);
    }
};

}  // namespace photond

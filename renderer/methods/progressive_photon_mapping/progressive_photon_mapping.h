#pragma once
#include "renderer/progressive/progressive_mapping.h"

namespace photond {

struct ProgressivePhotonMappingParams final : ProgressiveParams {
    uint32_t eye_samples = 4;

    ProgressivePhotonMappingParams() { radius_rule = RadiusRule::Local; }
    void visit(ParamVisitor& visitor) override;
};

/// Progressive photon mapping: fixed hit points of the eye, each with a radius of its own that shrinks as photons come.
///
/// The eye's paths are the same in every `eye_samples`-th pass: so many hit points a pixel, in turn. What happens at
/// them is said in progressive/progressive_mapping.h, how radii shrink in progressive/disc_radii.h; light of the lights
/// themselves is sampled anew in each pass. By the rule `local`, as published, a point's noise falls as
/// N^-alpha and its bias as N^(alpha - 1) with the passes N.
///
/// Strong where light reaches matte surfaces by glass and mirrors and is seen through them, which no path from either
/// side finds: consistent there, as all of photon mapping's progressive forms. Edges of things, depth of field and
/// gloss stay as coarse as the few hit points a pixel are: stochastic_progressive_photon_mapping draws new ones. Passes
/// build on those before where `radius_rule` is local or tested: such films cannot be merged or cut. Biased at any
/// time by the radii at hand (layer `bias_estimate`); with `boundary` none by what discs lose near edges of surfaces.
/// Not implemented: participating media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// [Hachisuka, Ogaki, Jensen 2008] Progressive Photon Mapping. ACM TOG 27(5).
class ProgressivePhotonMapping final : public ProgressiveMapping {
public:
    static constexpr const char* kName = "progressive_photon_mapping";
    using Params = ProgressivePhotonMappingParams;

    explicit ProgressivePhotonMapping(const Params& params)
        : ProgressiveMapping(std::make_unique<Params>(params), params.eye_samples) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMapping::estimate_bytes(params, params.eye_samples, workload);
    }
    static uint64_t estimate_state_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMapping::estimate_state_bytes(params, params.eye_samples, workload);
    }
};

}  // namespace photond

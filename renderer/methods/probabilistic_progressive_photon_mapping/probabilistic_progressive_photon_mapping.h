#pragma once
#include "renderer/progressive/progressive_mapping.h"

namespace photond {

struct ProbabilisticProgressivePhotonMappingParams final : ProgressiveParams {
    /// Only rules by which passes stand alone.
    void check() const override;
};

/// Progressive photon mapping without statistics: passes that stand alone, and are averaged.
///
/// A pass of index i is photon mapping with radii that are a function of place and i alone, so that any pass can be
/// rendered anywhere, and films are cut and merged freely. What happens at hit points is said in
/// progressive/progressive_mapping.h, how radii shrink in progressive/disc_radii.h. By the rule `global`, as published,
/// one radius serves the scene; by `trained`, each place has its own from a pilot, with which noise and bias are
/// balanced there.
///
/// Strong where light reaches matte surfaces by glass and mirrors and is seen through them. Noise falls as N^-alpha,
/// bias as N^(alpha - 1) with the passes N. Biased at any time by the radii at hand (layer `bias_estimate`); with
/// `boundary` none by what discs lose near edges of surfaces.
/// Not implemented: participating media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// [Knaus and Zwicker 2011] Progressive Photon Mapping: A Probabilistic Approach. ACM TOG 30(3).
/// [Kaplanyan and Dachsbacher 2013] Adaptive Progressive Photon Mapping. ACM TOG 32(2).
class ProbabilisticProgressivePhotonMapping final : public ProgressiveMapping {
public:
    static constexpr const char* kName = "probabilistic_progressive_photon_mapping";
    using Params = ProbabilisticProgressivePhotonMappingParams;

    explicit ProbabilisticProgressivePhotonMapping(const Params& params)
        : ProgressiveMapping(std::make_unique<Params>(params), 0) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMapping::estimate_bytes(params, 0, workload);
    }
    static uint64_t estimate_state_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMapping::estimate_state_bytes(params, 0, workload);
    }
};

}  // namespace photond

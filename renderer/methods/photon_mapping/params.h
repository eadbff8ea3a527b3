#pragma once
// The parameters of photon mapping: what it has beside those of all methods that gather.

#include "renderer/gathering/gathering_params.h"

namespace photond {

enum class Gather : uint8_t { Direct, Final };

struct PhotonMappingParams final : GatheringParams {
    Gather gather = Gather::Final;
    bool precompute_irradiance = true;
    PhotonSearch::Kind search = PhotonSearch::Kind::Nearest;

    void visit(ParamVisitor& visitor) override;

    bool final_gather() const override { return gather == Gather::Final; }
    PhotonSearch::Kind search_kind() const override { return search; }
    bool precomputes_irradiance() const override { return precompute_irradiance; }
};

inline void PhotonMappingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kGathers[] = {"direct", "final"};
    static constexpr std::string_view kSearches[] = {"nearest", "radius"};

    visit_light(visitor);
    visitor.enumeration("gather", gather,
                        {Light, kGathers,
                         "diffuse interreflection by looking the global map up where the eye sees (direct) or at the "
                         "ends of gather rays (final)"});
    visit_rays(visitor);
    visitor.flag("precompute_irradiance", precompute_irradiance,
                 {Gathering,
                  "final gather: irradiance is worked out at one photon of four beforehand, and the nearest is taken, "
                  "where there are at least two gather rays for each of these photons; sooner right, and surfaces at "
                  "the ends of gather rays count as Lambert reflectors"});
    visitor.enumeration("search", search,
                        {DensityEstimate, kSearches,
                         "photons of an estimate: the k nearest (kd-tree) or all within a radius (hash "
                         "grid)"});
    visit_estimate(visitor);
}

}  // namespace photond

#pragma once
// The parameters of reverse photon mapping: what it has beside those of all methods that gather.

#include "renderer/gathering/gathering_params.h"

namespace photond {

/// How far a photon's light is spread.
enum class InfluenceRadius : uint8_t { Fixed, Knn, Leaf };

struct ReversePhotonMappingParams final : GatheringParams {
    InfluenceRadius influence_radius = InfluenceRadius::Leaf;
    uint32_t tile_points = 1 << 18;

    void visit(ParamVisitor& visitor) override;

    bool final_gather() const override { return true; }
    PhotonSearch::Kind search_kind() const override {
        return influence_radius == InfluenceRadius::Fixed ? PhotonSearch::Kind::Radius : PhotonSearch::Kind::Nearest;
    }
    bool precomputes_irradiance() const override { return false; }
};

inline void ReversePhotonMappingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kInfluenceRadii[] = {"fixed", "knn", "leaf"};

    visit_light(visitor);
    visit_rays(visitor);
    visitor.field("tile_points", tile_points,
                  {Gathering, "points", 1024, 1 << 24,
                   "ends of gather rays that a thread keeps before photons stream past them; each takes about 150 "
                   "bytes, and the image does not depend on it"});
    visitor.enumeration("influence_radius", influence_radius,
                        {DensityEstimate, kInfluenceRadii,
                         "radius of a photon's disc: fixed; knn: the distance of the photon nearest but k to it; leaf: "
                         "as many photons as k, by the size and the photons of its leaf of the kd-tree"});
    visit_estimate(visitor);
}

}  // namespace photond

#pragma once
// Parameters that the bidirectional methods have in common, declared once.

#include <optional>

#include "protocol/param_info.h"
#include "renderer/bidirectional/mis_weights.h"
#include "renderer/photons/radius_schedule.h"
#include "renderer/progressive/progressive_params.h"
#include "renderer/transport/roulette_shared.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// Which vertices of light paths a vertex of the eye's path is connected with.
enum class Connections : uint8_t {
    Cache,    // drawn from those of all light paths of the pass
    OwnPath,  // all those of one light path
};

/// How much merging counts for beside the other ways to make a path.
enum class MergeWeights : uint8_t {
    Automatic,         // CorrelationAware, but on a GPU, which has only the other
    Recursive,         // mis_weights.h alone
    CorrelationAware,  // merging_correlation.h
};

/// How eye and light paths are merged.
struct MergingParams {
    RadiusRule radius_rule = RadiusRule::Global;  // or Trained
    float alpha = static_cast<float>(kRadiusAlpha);
    uint32_t nearest_vertices = 12;
    std::optional<float> radius_m;
    std::optional<float> radius_relative;
    std::optional<float> caustic_radius_share;
    MergeWeights weights = MergeWeights::Automatic;

    bool correlated() const { return weights != MergeWeights::Recursive; }

    void visit(ParamVisitor& visitor);
    /// `radius` and `radius_relative` exclude each other.
    void check() const;
};

struct BidirectionalParams : MethodParams {
    std::optional<uint32_t> indirect_bounces;
    bool adapt = true;
    std::optional<float> light_paths;  // a pixel
    Connections connections = Connections::Cache;
    std::optional<uint32_t> connections_per_vertex;
    MisHeuristic heuristic = MisHeuristic::Balance;
    uint32_t roulette_start = ROULETTE_START;
    uint32_t light_cache_mib = 64;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    /// nullptr where nothing merges.
    virtual const MergingParams* merging() const { return nullptr; }

    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return indirect_bounces ? *indirect_bounces + 1 : UINT32_MAX; }
};

}  // namespace photond

#pragma once
// What the passes of a bidirectional render are to do, found by pilots before the first: how many light paths and
// connections, whether vertices merge and within which radius. The same on every device for the same weights of
// merging: a pure function of scene, view, parameters and seed.

#include <optional>

#include "renderer/bidirectional/light_paths.h"

namespace photond {

/// What the cache takes for one vertex, its row among the path's surfaces included where merging is weighed by them.
/// `merging`: nullptr where nothing merges.
uint64_t bytes_of_light_vertex(const MergingParams* merging);
/// Light paths a pixel that the cache has room for.
float most_light_paths(const BidirectionalParams& params, Size2 size, double vertices_per_path);
/// Of all pixels together.
uint32_t paths_of_pass(float light_paths, Size2 size);

/// Vertices of a light path, while nobody has counted them.
inline constexpr double kExpectedLightVertices = 3;
/// Passes differ from the pilot; what they keep is let grow by this.
inline constexpr double kLightVertexMargin = 1.1;

struct BidirectionalPlan {
    double vertices_per_path = 0;    // of light paths
    PassTechniques techniques;       // but for what changes from pass to pass; no light path: there is only the eye
    float first_radius_m = 0;        // of merging, in pass 0; 0: nothing merges
    float alpha = 0;                 // by which it shrinks (radius_schedule.h)
    std::optional<RadiusMap> radii;  // first_radius_m is the greatest of them
    std::unique_ptr<const DiscCoverage> coverage;  // where there may be merging
    std::optional<TechniqueBlocks> blocks;         // where they differ

    /// Radii, coverage and blocks stay the plan's.
    PassTechniques of_pass(uint32_t pass) const;
};

/// Of trained radii, what their training takes for a while included; 0 where there are none.
uint64_t estimate_radii_bytes(const MergingParams* merging);

/// Whether blocks of pixels may differ: a device's image has one choice.
enum class TechniquesBy : uint8_t { Image, Block };

/// `light`: traces the pilot. `bytes_of_path`: what skipping a light path of so many vertices saves.
BidirectionalPlan make_bidirectional_plan(const RenderContext& context, const BidirectionalParams& params,
                                          const BidirectionalScene& scene, LightPathTracer& light, TechniquesBy by,
                                          uint64_t (*bytes_of_path)(double vertices, const MergingParams* merging),
                                          Stats& stats);

}  // namespace photond

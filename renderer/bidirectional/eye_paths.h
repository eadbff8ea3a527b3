#pragma once
// The eye's sub-paths of a tile, and all that they are joined with on their way: lights they meet, light samples,
// connections with vertices of light paths, and merging with those that lie where they are.

#include <memory>

#include "renderer/bidirectional/light_paths.h"
#include "renderer/bidirectional/technique_choice.h"
#include "renderer/eye/tiles.h"
#include "renderer/photons/hash_grid.h"

namespace photond {

/// What the eye's paths of a pass are joined with.
struct JoinedPass {
    const PassTechniques& techniques;
    const LightPaths& light;
    const HashGrid* grid = nullptr;           // over the light's vertices, where there is merging
    std::span<const uint32_t> in_grid_order;  // the vertex of each of its points
    const PassSampler& sampler;
    uint64_t join_salt = 0;                          // of the pass
    std::span<const WeighedCandidate> candidates{};  // of a pilot: all samples are weighed by each
};

/// What a pilot's tile tells besides.
struct PilotTile {
    std::vector<EyePathSum> paths;  // pixel by pixel of the tile, by candidate
    std::vector<EyePathCounts> counts;
};

/// Scratch of one thread; reused from tile to tile.
class EyePathTracer {
public:
    static constexpr uint32_t kTileSide = 16;  // blocks of techniques have whole tiles

    EyePathTracer();
    ~EyePathTracer();
    EyePathTracer(EyePathTracer&&) noexcept;
    static uint64_t bytes_per_thread();

    /// Renders the tile's pixels of one pass into `image`, but for what light paths bring there by themselves.
    void trace_tile(const BidirectionalScene& shared, const JoinedPass& pass, const Tile& tile, PassImage& image,
                    Counts& counts, EyeSeconds& seconds, PilotTile* pilot = nullptr);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace photond

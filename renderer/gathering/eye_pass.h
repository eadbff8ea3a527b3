#pragma once
// Pass 2: the scene as the eye sees it. What is lit by light samples and by paths through specular parts the walk finds
// (A, B of photon_mapping.h); where rough parts wait for light the photon maps are asked, or rays are gathered (C, D).

#include <vector>

#include "renderer/eye/specular_walk.h"
#include "renderer/gathering/final_gather.h"

namespace photond {

/// What all tiles of a pass are traced with; all is borrowed.
struct EyePassSetting {
    const GatheringScene& shared;
    const PassMaps& maps;
    const PassSamplers& samplers;
};

/// Scratch of one thread; reused from tile to tile.
class EyePass {
public:
    // Small, as 64 gather rays a pixel are a lot of work for one thread.
    static constexpr uint32_t kTileSide = 16;
    static uint64_t bytes_per_thread();

    EyePass();

    /// Renders the tile's pixels of one pass into `image` and adds what it did to `counts` and `seconds`, of which
    /// `points` are lookups and gather rays; what light the maps bring to the ends of these is for `ends` to say.
    /// Cancelled: the pixels are unfinished.
    void trace_tile(const EyePassSetting& setting, const Tile& tile, RayEndLookups& ends, PassImage& image,
                    Counts& counts, EyeSeconds& seconds, const CancelToken& cancel);

private:
    class Guide;
    class Lookups;

    SpecularWalk walk_;
    std::vector<GatherPoint> gather_points_;  // of one vertex
    Neighbours neighbours_;
    FinalGather final_gather_;
};

}  // namespace photond

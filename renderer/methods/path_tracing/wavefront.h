#pragma once
// Traces a tile's paths together, vertex by vertex: all rays, then all shading, then all shadow rays.

#include "renderer/eye/eye_batch.h"
#include "renderer/methods/path_tracing/path_scene.h"

namespace photond {

/// Scratch of one thread; reused from tile to tile.
class Wavefront {
public:
    static constexpr uint32_t kTileSide = 32;
    static uint64_t bytes_per_thread();

    /// Renders the tile's pixels of one pass into `image` and adds what it did to `counts` and `seconds`.
    void trace_tile(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile, PassImage& image,
                    Counts& counts, EyeSeconds& seconds);

private:
    static constexpr size_t kPaths = size_t{kTileSide} * kTileSide;

    void draw_numbers(const PassSampler& sampler, uint32_t vertex);
    void shade_lambert(const PathTracingScene& shared, uint32_t vertex, PassImage& image);
    void shade_general(const PathTracingScene& shared, uint32_t vertex, PassImage& image);
    bool shade_vertex(const PathTracingScene& shared, uint32_t vertex, uint32_t i, PassImage& image);

    EyeBatch batch_{kPaths};
    ShadowBatch<WaitingLight> shadows_{kPaths};
    PathNumbers light_point_{kPaths}, choice_{kPaths}, direction_{kPaths}, lobe_{kPaths};
};

}  // namespace photond

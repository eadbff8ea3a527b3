#pragma once
// Paths from the eye that light samples are weighed against alone: traces a tile's together, vertex by vertex: all
// rays, then all shading, then all shadow rays. What path tracing is, and whoever finds that it needs no more.

#include "renderer/eye/eye_batch.h"

namespace photond {

/// What all tiles and passes share. Each light sample is weighed against a sample of the BSDF whose ray is traced, at
/// the last vertex, too: those of the environment may leave to it what it finds well.
struct PathScene : EyeScene {
    PathScene(const RenderContext& context, SamplerKind sampler_kind, uint32_t most_scatterings,
              uint32_t roulette_starts_at)
        : EyeScene(context, sampler_kind, most_scatterings, EnvironmentDensity::Compensated),
          roulette_start(roulette_starts_at) {}

    const uint32_t roulette_start;  // surface interactions after which Russian roulette may end a path
};

/// Scratch of one thread; reused from tile to tile.
class PathWavefront {
public:
    static constexpr uint32_t kTileSide = 32;
    static uint64_t bytes_per_thread();

    /// Renders the tile's pixels of one pass into `image` and adds what it did to `counts` and `seconds`.
    void trace_tile(const PathScene& shared, const PassSampler& sampler, const Tile& tile, PassImage& image,
                    Counts& counts, EyeSeconds& seconds);

private:
    static constexpr size_t kPaths = size_t{kTileSide} * kTileSide;

    void draw_numbers(const PassSampler& sampler, uint32_t vertex);
    void shade_lambert(const PathScene& shared, uint32_t vertex, PassImage& image);
    void shade_general(const PathScene& shared, uint32_t vertex, PassImage& image);
    bool shade_vertex(const PathScene& shared, uint32_t vertex, uint32_t i, PassImage& image);

    EyeBatch batch_{kPaths};
    ShadowBatch<WaitingLight> shadows_{kPaths};
    PathNumbers light_point_{kPaths}, choice_{kPaths}, direction_{kPaths}, lobe_{kPaths};
};

}  // namespace photond

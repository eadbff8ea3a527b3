#pragma once
// Traces a tile's paths together, vertex by vertex: all rays, then all shading, then all shadow rays.

#include <vector>

#include "renderer/methods/path_tracing/path.h"
#include "renderer/methods/path_tracing/path_scene.h"

namespace photond {

/// CPU seconds of the thread, by part of the path (conventions.md, "Paths, layers, bounces").
struct PathSeconds {
    double camera = 0;    // camera rays and their first hits
    double direct = 0;    // first vertices
    double indirect = 0;  // all further vertices
};

/// Scratch of one thread; reused from tile to tile.
class Wavefront {
public:
    static constexpr uint32_t kTileSide = 32;
    static uint64_t bytes_per_thread();

    Wavefront();

    /// Renders the tile's pixels of one pass into `image` and adds what it did to `counts` and `seconds`.
    void trace_tile(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile, PassImage& image,
                    Counts& counts, PathSeconds& seconds);

private:
    static constexpr size_t kPaths = size_t{kTileSide} * kTileSide;

    /// A light sample that waits for its shadow ray.
    struct Pending {
        Rgb radiance;
        uint32_t pixel;
        bool indirect;
    };

    void start_paths(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile);
    void draw_numbers(const PassSampler& sampler, uint32_t vertex, bool lobes);
    template <bool kPlain>
    void shade(const PathTracingScene& shared, uint32_t vertex, PassImage& image);
    template <bool kPlain>
    bool shade_vertex(const PathTracingScene& shared, uint32_t vertex, size_t i, PassImage& image);
    void trace_shadow_rays(const PathTracingScene& shared, uint32_t vertex, PassImage& image, Counts& counts);

    size_t count_ = 0;  // paths that go on: the first count_ of the arrays
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<Path> paths_;
    std::vector<uint32_t> keys_;  // of the sampler
    std::vector<Ray> shadow_rays_;
    std::vector<Pending> pending_;
    std::vector<uint8_t> occluded_;
    struct Numbers {
        std::vector<float> x, y;
    };
    Numbers light_point_, choice_, direction_, lobe_;
};

}  // namespace photond

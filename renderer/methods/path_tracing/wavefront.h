#pragma once
// Traces a tile's paths together, vertex by vertex: all rays, then all shading, then all shadow rays.

#include <vector>

#include "renderer/eye/eye_path.h"
#include "renderer/eye/tiles.h"
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

    void sort_hits(const PathTracingScene& shared, PassImage& image);
    void draw_numbers(const PassSampler& sampler, uint32_t vertex);
    void shade_lambert(const PathTracingScene& shared, uint32_t vertex, PassImage& image);
    void shade_general(const PathTracingScene& shared, uint32_t vertex, PassImage& image);
    bool shade_vertex(const PathTracingScene& shared, uint32_t vertex, uint32_t i, PassImage& image);
    void trace_shadow_rays(const PathTracingScene& shared, uint32_t vertex, PassImage& image, Counts& counts);

    // All of these hold kPaths; how many count is said here. Paths that go on, shadow rays and what waits for them are
    // written where they stay, number by number: a struct that is pieced together and then copied is read by wider
    // loads than it was written, for which the processor waits (5 % of a whole pass).
    size_t count_ = 0;  // of the paths under way
    size_t next_count_ = 0;
    size_t shadow_count_ = 0;
    std::vector<Ray> rays_, next_rays_;
    std::vector<EyePath> paths_, next_paths_;
    std::vector<uint32_t> keys_, next_keys_;  // of the sampler
    std::vector<Hit> hits_;
    std::vector<uint32_t> lambert_, general_;  // paths by how their hits are shaded
    std::vector<Ray> shadow_rays_;
    std::vector<Pending> pending_;
    std::vector<uint8_t> occluded_;
    struct Numbers {
        std::vector<float> x, y;
    };
    Numbers light_point_, choice_, direction_, lobe_;
};

}  // namespace photond

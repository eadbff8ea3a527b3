#pragma once
// Pass 2: the scene as the eye sees it, lit by light sampling, by paths through specular parts, and by the photon maps.
// A tile's paths are traced together, vertex by vertex.

#include <vector>

#include "renderer/methods/photon_mapping/final_gather.h"
#include "renderer/methods/tiles.h"

namespace photond {

/// CPU seconds of the thread, by part of the work.
struct EyePassSeconds {
    double camera = 0;    // camera rays and their first hits
    double direct = 0;    // first vertices: their shading and shadow rays
    double indirect = 0;  // further vertices of the eye's paths
    double gather = 0;    // lookups and gather rays
};

/// Scratch of one thread; reused from tile to tile.
class EyePass {
public:
    // Small, as 64 gather rays a pixel are a lot of work for one thread.
    static constexpr uint32_t kTileSide = 16;
    static uint64_t bytes_per_thread();

    EyePass();

    /// Renders the tile's pixels of one pass into `image` and adds what it did to `counts` and `seconds`. Cancelled:
    /// the pixels are unfinished.
    void trace_tile(const PhotonMappingScene& shared, const PassMaps& maps, const PassSamplers& samplers,
                    const Tile& tile, PassImage& image, Counts& counts, EyePassSeconds& seconds,
                    const CancelToken& cancel);

private:
    static constexpr size_t kPaths = size_t{kTileSide} * kTileSide;
    static constexpr size_t kShadowRays = 4096;  // of a batch; as many light samples as a vertex may have fit in

    /// A vertex, and the parts of its BSDF that light samples are for.
    struct LitPoint {
        const ShadingPoint& surface;
        const Bsdf& specular;
        const Bsdf& rough;
        vec3 wo;               // local
        uint32_t samples;      // of lights
        uint32_t gather_rays;  // that meet lights
    };

    void sort_hits(const PhotonMappingScene& shared, PassImage& image);
    void draw_numbers(const PassSampler& sampler, uint32_t vertex);
    bool shade_vertex(const PhotonMappingScene& shared, const PassMaps& maps, const SplitSamplers& light_samplers,
                      uint32_t vertex, uint32_t i, PassImage& image, Counts& counts);
    void sample_lights(const PhotonMappingScene& shared, const PassMaps& maps, const SplitSamplers& samplers,
                       const LitPoint& point, const EyePath& path, uint32_t key, uint32_t vertex, PassImage& image);
    void trace_shadow_rays(const PhotonMappingScene& shared, uint32_t vertex, PassImage& image, Counts& counts);
    void look_up_maps(const PhotonMappingScene& shared, const PassMaps& maps, PassImage& image);

    // All of these hold kPaths; how many count is said here.
    size_t count_ = 0;  // of the paths under way
    size_t next_count_ = 0;
    std::vector<Ray> rays_, next_rays_;
    std::vector<EyePath> paths_, next_paths_;
    std::vector<uint32_t> keys_, next_keys_;  // of the sampler
    std::vector<Hit> hits_;
    std::vector<uint32_t> order_;             // of the hits: those that met something
    std::vector<GatherPoint> gather_points_;  // of this vertex
    struct Numbers {
        std::vector<float> x, y;
    };
    Numbers roulette_, direction_, lobe_;
    // These hold kShadowRays.
    size_t shadow_count_ = 0;
    std::vector<Ray> shadow_rays_;
    std::vector<PendingLight> pending_;
    std::vector<uint8_t> occluded_;
    Neighbours neighbours_;
    FinalGather final_gather_;
};

}  // namespace photond

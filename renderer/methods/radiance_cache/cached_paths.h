#pragma once
// Paths from points that the eye sees to where a cache of radiance can be asked: what they bring goes to the image, or,
// of paths that fill the cache, to the cells of their vertices.
//
// A path goes on as in path tracing, with a light sample at each vertex, until it ends in a cell that knows enough:
// what the rough part of the surface there sends on is the cell's, lobes too narrow for it are followed. Where a ray
// was too short, or nobody has been before, it simply goes on: a miss costs time and no bias.
//
// Cells keep outgoing radiance over the surface's albedo, so that textures are not blurred.

#include <span>
#include <vector>

#include "renderer/core/cancel.h"
#include "renderer/core/stats.h"
#include "renderer/eye/eye_batch.h"
#include "renderer/gathering/final_gather.h"
#include "renderer/methods/radiance_cache/params.h"
#include "renderer/methods/radiance_cache/radiance_cells.h"

namespace photond {

/// Which directions a cell is of that holds what a surface with that rough part sends towards the eye (unit, world): 0
/// where that is the same all around.
uint32_t cell_direction(const Bsdf& rough, const vec3& to_eye, uint32_t direction_bins);

/// Scratch of one thread.
class CachedPaths {
public:
    static constexpr uint32_t kRays = 1024;      // of a batch
    static constexpr uint32_t kMostRecords = 8;  // vertices of a path that leave a sample, the first ones

    /// What all points of a tile go by.
    struct Pass {
        const EyeScene& shared;
        const RadianceCacheParams& params;
        const CellGrid& grid;
        const RadianceCells* cells;  // null: paths end nowhere but by themselves
        const SplitSamplers& samplers;
        uint32_t key;  // of the cells' own numbers
        PassImage& image;
        Counts& counts;
    };

    CachedPaths();
    static uint64_t bytes_per_thread();

    /// Adds what the points gather to the image.
    void gather(const Pass& pass, std::span<const GatherPoint> points, const CancelToken& cancel);
    /// Follows one path from each point and appends what its vertices send back: nothing is added to the image.
    void train(const Pass& pass, std::span<const GatherPoint> points, std::vector<CellSample>& samples,
               const CancelToken& cancel);

private:
    struct Path {
        Rgb throughput;   // since the point
        float eta_scale;  // since the point, as in EyePath
        uint32_t point;   // index in the batch
        uint32_t scatterings;
        uint32_t trail;     // that its records are in
        float spread_m;     // of its rays up to the last vertex; with pdf_sa of the next one
        float bsdf_pdf_sa;  // with which the ray was drawn; infinite: by a delta lobe
        bool caustic;       // all scatterings after x_1 were delta
        // Of the last vertex, as given to the light sampler; weight_pdf_sa is what light samples there are weighed by,
        // 0: none compete.
        vec3 position, lit_normal;
        float weight_pdf_sa;
        MediumStack media;
    };
    /// Of a surface, world.
    struct Place {
        vec3 position, geometric_normal, normal;
    };
    /// A vertex that leaves a sample.
    struct Record {
        Place place;
        uint32_t direction, level;
        float spread_m;
        Rgb inverse_albedo;  // 0 where the albedo is
        Rgb through;         // what arrives at the path's end times this leaves the vertex
        Rgb through_before;  // ... as it was when the last vertex was reached
        Rgb radiance;
        uint32_t random;
    };
    struct WaitingSample {
        Rgb radiance;  // at the last vertex, over the path's throughput
        Rgb rough;     // of it, by the rough part
        uint32_t path_trail;
        uint32_t records;  // of the trail then; the last is the vertex's own where `own` says so
        bool own;
    };

    static RadianceCells::Mean ask(const Pass& pass, const Place& place, uint32_t direction, uint32_t finest,
                                   float spread_m, const vec2& u);
    void run(const Pass& pass, std::span<const GatherPoint> points);
    void start(const Pass& pass, std::span<const GatherPoint> points);
    void shade(const Pass& pass, const GatherPoint& origin, uint32_t vertex, uint32_t i);
    void add(const Pass& pass, const GatherPoint& origin, const Path& path, const Rgb& radiance);
    void scale(Path& path, const Rgb& weight);
    void add_emitted(const Pass& pass, const GatherPoint& origin, const Path& path, const Rgb& radiance,
                     float light_pdf_sa);
    void arrive(const Pass& pass, const GatherPoint& origin, uint32_t i);
    void add_to_trail(uint32_t trail, const Rgb& radiance);
    void scale_trail(uint32_t trail, const Rgb& weight);
    bool keeps_samples_at(const Pass& pass, const GatherPoint& origin, const Path& path) const;

    bool training_ = false;
    PathBatch<Path> batch_{kRays};
    ShadowBatch<WaitingLight> shadows_{kRays};
    ShadowBatch<WaitingSample> trail_shadows_{kRays};
    std::vector<uint32_t> met_;           // paths that met a surface
    std::vector<Record> records_;         // kMostRecords a trail
    std::vector<uint32_t> record_count_;  // by trail
};

}  // namespace photond

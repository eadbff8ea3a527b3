#pragma once
#include "renderer/frame/follows_frames.h"
#include "renderer/frame/method.h"
#include "renderer/methods/radiance_cache/aged_cells.h"
#include "renderer/methods/radiance_cache/params.h"

namespace photond {

/// A world-space radiance cache: paths from the eye end in it at the first rough vertex past the first bounce.
///
/// What the eye sees first, direct light there, and paths through what is specular are traced as ever. From each point
/// that waits for indirect light rays are gathered; where one ends, a hash grid of cells says what the surface sends
/// on, direct light and all bounces. Few paths, of all bounces, fill the cells before: each of their vertices is a
/// sample of its cell. So the light that a gather ray brings is the mean of many samples, and costs no more than a ray.
///
/// A cell's side follows from its distance to the eye and from the length of the ray that asks (cell_grid.h); sides of
/// a thin wall, and directions of what is not Lambert, are apart. Where no cell knows enough the path goes on as in
/// path tracing. Memory is fixed; what finds no room is not kept (radiance_cells.h).
///
/// Biased by the cells' width; with `shrink` they shrink from pass to pass, and the mean of the passes converges. A
/// cache serves a block of 1, 2, 4, 8 and then 16 passes and is filled by as many passes' paths: what a pass is follows
/// from its index alone, and with `aged` from the cells of the frame before, which each block begins with; the last
/// block's are left to the next frame (aged_cells.h). Strong where light bounces often and softly; caustics are as
/// noisy as path tracing's, or worse, as they are blurred by the cells.
///
/// [Binder, Fricke, Keller 2018] Fast Path Space Filtering by Jittered Spatial Hashing. SIGGRAPH Talks.
/// [Müller et al. 2021] Real-time Neural Radiance Caching for Path Tracing. ACM TOG 40(4) (where paths end).
/// [Boissé et al. 2023] GI-1.0: A Fast and Scalable Two-level Radiance Caching Scheme for Real-Time GI.
class RadianceCache final : public FollowsFrames<Method, CellsBetweenFrames> {
public:
    static constexpr const char* kName = "radiance_cache";
    using Params = RadianceCacheParams;

    explicit RadianceCache(const RadianceCacheParams& params);
    ~RadianceCache() override;
    /// What begin() will record.
    static uint64_t estimate_bytes(const RadianceCacheParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;

private:
    struct State;

    const RadianceCacheParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond

#include "renderer/methods/path_tracing/path_tracing.h"

#include "renderer/core/thread_local.h"
#include "renderer/eye/path_wavefront.h"

namespace photond {

struct PathTracing::Scratch {
    struct PerThread {
        PathWavefront wavefront;
        Counts counts;
        EyeSeconds seconds;
    };
    ThreadLocal<PerThread> threads;
};

PathTracing::PathTracing(const PathTracingParams& params) : params_(params) {}
PathTracing::~PathTracing() = default;

uint64_t PathTracing::estimate_bytes(const PathTracingParams& /*params*/, const Workload& workload) {
    return PassImage::bytes_for(workload.film_size, workload.layers) +
           workload.threads * PathWavefront::bytes_per_thread() +
           LightSampler::estimate_bytes(workload.lights, workload.environment_size);
}

void PathTracing::begin(const RenderContext& context, Stats& stats) {
    const uint64_t image_bytes = PassImage::bytes_for(context.view.film_size, context.view.layers);
    const uint64_t wavefront_bytes = most_threads() * PathWavefront::bytes_per_thread();
    context.budget.require("pass_image", image_bytes);
    context.budget.require("wavefronts", image_bytes + wavefront_bytes);
    scene_ = std::make_unique<PathScene>(context, params_.sampler, params_.max_scatterings(), params_.roulette_start);
    scratch_ = std::make_unique<Scratch>();
    image_ = PassImage(context.view.film_size, context.view.layers);
    context.budget.record("pass_image", image_bytes);
    context.budget.record("wavefronts", wavefront_bytes);
    context.budget.record("light_sampler", scene_->lights.bytes());

    const Needs& needs = context.scene.needs;
    if (needs.only_lambert())
        stats.skipped.push_back({"layered shading", "every surface is a plain Lambert reflector", 0});
    if (!needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
    if (!needs.alpha) stats.skipped.push_back({"alpha test of rays", "no surface is masked or blended", 0});
}

void PathTracing::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    pass_complete_ = false;
    const double wall_start = wall_now_seconds();
    const PassSampler sampler(scene_->sampler, scene_->seed, RandomDomain::Camera, pass);
    parallel_over_tiles(scene_->view.film_size, PathWavefront::kTileSide, cancel, [&](const Tile& tile) {
        Scratch::PerThread& mine = scratch_->threads.local();
        mine.wavefront.trace_tile(*scene_, sampler, tile, image_, mine.counts, mine.seconds);
    });

    const EyeSeconds cpu = take_work(scratch_->threads, stats);
    add_interleaved_stages(stats, wall_now_seconds() - wall_start,
                           {{"g_buffer", cpu.camera}, {"direct", cpu.direct}, {"indirect", cpu.indirect}});
    pass_complete_ = !cancel.cancelled();
}

PassImage* PathTracing::end_pass() { return pass_complete_ ? &image_ : nullptr; }

}  // namespace photond

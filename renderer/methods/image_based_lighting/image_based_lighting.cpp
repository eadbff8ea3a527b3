#include "renderer/methods/image_based_lighting/image_based_lighting.h"

#include <optional>

#include "renderer/core/thread_local.h"
#include "renderer/methods/image_based_lighting/environment_light.h"
#include "renderer/methods/image_based_lighting/lamp_rays.h"

namespace photond {

namespace {

constexpr uint32_t kTileSide = 32;

}  // namespace

PrefilterSettings prefilter_of(const ImageBasedLightingParams& params) {
    return {params.prefilter_resolution, params.prefilter_levels};
}

uint64_t prefilter_bytes(const ImageBasedLightingParams& params, Size2 environment_size) {
    if (environment_size.pixels() == 0) return 0;
    return PrefilteredEnvironment::bytes_for(prefilter_of(params)) +
           PrefilteredEnvironment::scratch_bytes(prefilter_of(params), environment_size);
}

PrefilteredEnvironment prefilter_environment(const Scene& scene, const EnvironmentSampler& sampler,
                                             const ImageBasedLightingParams& params, MemoryBudget& budget,
                                             Stats& stats) {
    const StageTimer timer(stats, "prefilter");
    budget.require("prefiltered_environment", prefilter_bytes(params, scene.environment->map.size));
    PrefilteredEnvironment made(*scene.environment, sampler, prefilter_of(params));
    budget.record("prefiltered_environment", PrefilteredEnvironment::bytes_for(prefilter_of(params)));
    // It has been given back, but it was there.
    budget.record("environment_pyramid",
                  PrefilteredEnvironment::scratch_bytes(prefilter_of(params), scene.environment->map.size));
    return made;
}

void note_skipped_by_image_based_lighting(const Scene& scene, const ImageBasedLightingParams& params, Stats& stats) {
    stats.skipped.push_back({"indirect light", "light that bounces is not followed", 0});
    if (!scene.environment) {
        stats.skipped.push_back({"prefiltered environment", "the scene has no environment",
                                 PrefilteredEnvironment::bytes_for(prefilter_of(params))});
        return;
    }
    stats.skipped.push_back({"visibility of the environment", "nobody asks what stands before it", 0});
    if (scene.needs.solid_glass && scene.needs.glossy)
        stats.skipped.push_back(
            {"environment through rough solids", "what such an interface refracts is not followed", 0});
}

struct ImageBasedLighting::State {
    struct PerThread {
        SpecularWalk walk{kTileSide};
        Counts counts;
        EyeSeconds seconds;
    };

    State(const RenderContext& context, SamplerKind sampler)
        : eye(context, sampler, kImageBasedScatterings),
          lamps(context.scene),
          image(context.view.film_size, context.view.layers) {}

    const EyeScene eye;
    LampsAlone lamps;                                   // keeps nothing
    std::optional<PrefilteredEnvironment> environment;  // none: nor has the scene
    PassImage image;
    ThreadLocal<PerThread> threads;
    bool pass_complete = false;  // image holds a whole pass
};

ImageBasedLighting::ImageBasedLighting(const ImageBasedLightingParams& params) : params_(params) {}
ImageBasedLighting::~ImageBasedLighting() = default;

uint64_t ImageBasedLighting::estimate_bytes(const ImageBasedLightingParams& params, const Workload& workload) {
    return PassImage::bytes_for(workload.film_size, workload.layers) +
           workload.threads * SpecularWalk::bytes_per_thread(kTileSide) +
           LightSampler::estimate_bytes(workload.lights, workload.environment_size) +
           prefilter_bytes(params, workload.environment_size);
}

void ImageBasedLighting::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    MemoryBudget& budget = context.budget;
    const uint64_t image_bytes = PassImage::bytes_for(context.view.film_size, context.view.layers);
    const uint64_t walk_bytes = most_threads() * SpecularWalk::bytes_per_thread(kTileSide);
    budget.require("pass_image", image_bytes);
    budget.require("wavefronts", image_bytes + walk_bytes);
    state_ = std::make_unique<State>(context, params_.sampler);
    budget.record("pass_image", image_bytes);
    budget.record("wavefronts", walk_bytes);
    budget.record("light_sampler", state_->eye.lights.bytes());
    if (scene.environment)
        state_->environment.emplace(
            prefilter_environment(scene, *state_->eye.lights.environment(), params_, budget, stats));
    note_skipped_by_image_based_lighting(scene, params_, stats);
}

void ImageBasedLighting::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.pass_complete = false;
    const double wall_start = wall_now_seconds();
    const PassSampler sampler(state.eye.sampler, state.eye.seed, RandomDomain::Camera, pass);
    const WalkSettings settings{.glossy_threshold = 0, .guide = &state.lamps};
    parallel_over_tiles(state.eye.view.film_size, kTileSide, cancel, [&](const Tile& tile) {
        State::PerThread& mine = state.threads.local();
        std::optional<EnvironmentLight> environment;
        if (state.environment) environment.emplace(*state.environment, state.image);
        LampRays lamps(state.eye, mine.walk, sampler, state.image, mine.counts, environment ? &*environment : nullptr);
        mine.walk.trace_tile(state.eye, settings, {sampler, std::span(&sampler, 1)}, tile, state.image, mine.counts,
                             mine.seconds, cancel, lamps);
    });
    const EyeSeconds cpu = take_work(state.threads, stats);
    add_interleaved_stages(stats, wall_now_seconds() - wall_start,
                           {{"g_buffer", cpu.camera}, {"direct", cpu.direct + cpu.indirect + cpu.points}});
    state.pass_complete = !cancel.cancelled();
}

PassImage* ImageBasedLighting::end_pass() { return state_->pass_complete ? &state_->image : nullptr; }

}  // namespace photond

#include "renderer/many_lights/first_bounce_gpu.h"

#include "renderer/backends/gpu/device_intersector.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/scene/scene.h"

namespace photond {

FirstBounceGpu::FirstBounceGpu(const RenderContext& context, const FirstBounceSettings& settings, Stats& stats)
    : scene_(*context.device_scene),
      device_(scene_.device()),
      seed_(context.seed),
      layers_(context.view.layers),
      device_image_(device_, context.view.film_size, layers_),
      buffer_(scene_, context.view, seed_, settings.walk, device_image_, nullptr),
      merge_(scene_, buffer_, device_image_, layers_, settings.filter),
      image_(context.view.film_size, layers_),
      queue_(device_) {
    context.budget.record("pass_image", PassImage::bytes_for(context.view.film_size, layers_));
    const Needs& needs = context.scene.needs;
    if (needs.only_lambert())
        stats.skipped.push_back({"layered shading", "every surface is a plain Lambert reflector", 0});
    if (!needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
    if (settings.bounces > 0)
        find_lights(context, settings, stats);
    else
        stats.skipped.push_back({"virtual point lights", "bounces is 0", 0});
}

// The queue waits for what uses the others.
FirstBounceGpu::~FirstBounceGpu() { device_.wait_idle(); }

void FirstBounceGpu::find_lights(const RenderContext& context, const FirstBounceSettings& settings, Stats& stats) {
    const Scene& scene = context.scene;
    emission_.emplace(scene);
    if (!(emission_->total_power_w() > 0)) {
        emission_.reset();
        stats.skipped.push_back({"virtual point lights", "the scene has no light", 0});
        return;
    }
    context.budget.record("emission_sampler", emission_->bytes());
    {
        const StageTimer timer(stats, "rsm");
        const auto lit_area_m2 = [&] {
            const VplTracer tracer(scene, *context.intersector, *context.intersector, *emission_, settings.tracing);
            return static_cast<float>(tracer.lit_area_m2(context.seed));
        };
        clamp_sq_m2_ =
            settings.clamp_m2 ? *settings.clamp_m2 : default_clamp_sq_m2(lit_area_m2(), settings.tracing.vpls);
    }
    const StageTimer timer(stats, "pipelines");
    tracer_ = std::make_unique<VplTracerGpu>(scene_, *emission_, settings.tracing, counters(), false);
}

bool FirstBounceGpu::may_be_lit(const FirstBounceSettings& settings, const Workload& workload) {
    return settings.bounces > 0 && (workload.lights > 0 || workload.environment_size.pixels() > 0);
}

uint64_t FirstBounceGpu::estimate_bytes(const FirstBounceSettings& settings, const Workload& workload) {
    return PassImage::bytes_for(workload.film_size, workload.layers) +
           (may_be_lit(settings, workload) ? EmissionSampler::estimate_bytes(workload.lights, workload.environment_size)
                                           : 0);
}

uint64_t FirstBounceGpu::estimate_device_bytes(const FirstBounceSettings& settings, const Workload& workload) {
    const uint32_t side = settings.walk.split_side;
    const bool asks_lit_area = may_be_lit(settings, workload) && !settings.clamp_m2;
    return (asks_lit_area ? gpu::DeviceIntersector::batch_bytes() : 0) +
           DeviceImage::device_bytes(workload.film_size, workload.layers) +
           DeviceImage::host_bytes(workload.film_size, workload.layers) +
           GBufferGpu::device_bytes(workload.film_size, side, workload.needs) +
           GBufferMergeGpu::device_bytes(workload.film_size, side, settings.filter) +
           (may_be_lit(settings, workload)
                ? VplTracerGpu::device_bytes(settings.tracing, false, workload.needs.only_lambert(), workload.lights)
                : 0);
}

/// The pass's steps in order, as many at a time as one submit may hold.
std::vector<PieceQueue::Record> FirstBounceGpu::pieces(uint32_t pass) {
    std::vector<PieceQueue::Step> steps;
    steps.push_back({0, [this](gpu::CommandList& commands) { device_image_.record_clear(commands); }});
    for (uint32_t piece = 0; piece < buffer_.pieces(); ++piece)
        steps.push_back({buffer_.layout().size.pixels() / buffer_.pieces(),
                         [=, this](gpu::CommandList& commands) { buffer_.record(commands, pass, piece); }});
    if (lit()) {
        steps.push_back({tracer_->map_texels(), [=, this](gpu::CommandList& commands) {
                             tracer_->start(seed_, pass);
                             tracer_->record_map(commands);
                         }});
        add_steps_(pass, steps);
    }
    steps.push_back({0, [this](gpu::CommandList& commands) {
                         merge_.record(commands);
                         device_image_.record_readback(commands);
                     }});

    return PieceQueue::pieces_of(device_, std::move(steps));
}

void FirstBounceGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    pass_complete_ = false;
    const StageTimer timer(stats, "indirect");
    if (begun_ != pass) queue_.start(pieces(pass));
    begun_.reset();
    if (!queue_.finish(stats, cancel) || cancel.cancelled()) return;
    if (lit()) tracer_->add_to(stats.counts);
    device_image_.read(image_, stats.counts, scene_.scene().origin);
    pass_complete_ = true;
}

void FirstBounceGpu::expect_pass(uint32_t pass) {
    queue_.start(pieces(pass));
    begun_ = pass;
}

void FirstBounceGpu::settle() { device_.wait_idle(); }

void FirstBounceGpu::resolve(Film& film) {
    if (pass_complete_) film.add_pass(image_);
}

}  // namespace photond

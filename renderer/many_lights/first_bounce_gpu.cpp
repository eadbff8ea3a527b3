#include "renderer/many_lights/first_bounce_gpu.h"

#include "renderer/backends/gpu/device_intersector.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/scene/scene.h"

namespace photond {

FirstBounceGpu::FirstBounceGpu(const RenderContext& context, const FirstBounceSettings& settings, Stats& stats,
                               VplsBetweenFrames* frames)
    : scene_(*context.device_scene),
      seed_(context.seed),
      frame_(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }),
      buffer_(scene_, context.view, seed_, settings.walk, frame_.image()),
      merge_(scene_, buffer_, frame_.image(), context.view.layers, settings.filter) {
    note_skipped_shading(context.scene.needs, stats);
    if (settings.bounces > 0)
        find_lights(context, settings, stats, frames);
    else
        stats.skipped.push_back({"virtual point lights", "bounces is 0", 0});
}

FirstBounceGpu::~FirstBounceGpu() { frame_.end(); }

void FirstBounceGpu::find_lights(const RenderContext& context, const FirstBounceSettings& settings, Stats& stats,
                                 VplsBetweenFrames* frames) {
    const Scene& scene = context.scene;
    emission_.emplace(scene);
    if (!(emission_->total_power_w() > 0)) {
        emission_.reset();
        stats.skipped.push_back({"virtual point lights", "the scene has no light", 0});
        return;
    }
    context.budget.record("emission_sampler", emission_->bytes());
    const bool given = frames && frames->on();
    // The lights' map on the host, for what is asked once a frame.
    std::optional<VplTracer> on_host;
    if (!settings.clamp_m2 || given || selects_paths(settings.placement))
        on_host.emplace(scene, *context.intersector, *context.intersector, *emission_, settings.tracing);
    {
        const StageTimer timer(stats, "rsm");
        const auto lit_area_m2 = [&] { return static_cast<float>(on_host->lit_area_m2(context.seed)); };
        clamp_sq_m2_ =
            settings.clamp_m2 ? *settings.clamp_m2 : default_clamp_sq_m2(lit_area_m2(), settings.tracing.vpls);
    }
    std::optional<PathPilot> pilot;
    if (selects_paths(settings.placement)) {
        pilot = find_path_pilot(settings.placement, *on_host,
                                CameraImportance(scene, *context.intersector, context.view, clamp_sq_m2_, context.seed),
                                *context.intersector, settings.tracing.vpls, context.seed, stats);
    }
    if (given) frames->renew(*on_host, *emission_, context, stats);
    const StageTimer timer(stats, "pipelines");
    const bool by_camera = settings.placement == VplPlacement::Camera;
    tracer_ = std::make_unique<VplTracerGpu>(scene_, *emission_, settings.tracing, counters(), by_camera);
    if (by_camera) importance_.emplace(scene_, buffer_, nullptr, seed_, clamp_sq_m2_, tracer_->map_texels());
    if (pilot)
        selection_.emplace(scene_, *tracer_, buffer_, counters(), settings.placement, *pilot, settings.tracing.vpls,
                           seed_, clamp_sq_m2_);
    if (given) tracer_->start(frames->seed(), frames->paths());
}

bool FirstBounceGpu::may_be_lit(const FirstBounceSettings& settings, const Workload& workload) {
    return settings.bounces > 0 && (workload.lights > 0 || workload.environment_size.pixels() > 0);
}

uint64_t FirstBounceGpu::estimate_bytes(const FirstBounceSettings& settings, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload) +
           (may_be_lit(settings, workload) ? EmissionSampler::estimate_bytes(workload.lights, workload.environment_size)
                                           : 0);
}

uint64_t FirstBounceGpu::estimate_device_bytes(const FirstBounceSettings& settings, const Workload& workload) {
    const uint32_t side = settings.walk.split_side;
    const bool asks_lit_area = may_be_lit(settings, workload) && !settings.clamp_m2;
    return (asks_lit_area ? gpu::DeviceIntersector::batch_bytes() : 0) + DeviceFrame::estimate_device_bytes(workload) +
           GBufferGpu::device_bytes(workload.film_size, side, workload.needs) +
           GBufferMergeGpu::device_bytes(workload.film_size, side, settings.filter) +
           (may_be_lit(settings, workload)
                ? VplTracerGpu::device_bytes(settings.tracing, settings.placement == VplPlacement::Camera,
                                             workload.needs.only_lambert(), workload.lights)
                : 0) +
           (may_be_lit(settings, workload) && selects_paths(settings.placement)
                ? PathSelectionGpu::device_bytes(settings.placement, settings.tracing.vpls)
                : 0);
}

void FirstBounceGpu::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    for (uint32_t piece = 0; piece < buffer_.pieces(); ++piece)
        steps.push_back({buffer_.layout().size.pixels() / buffer_.pieces(),
                         [=, this](gpu::CommandList& commands) { buffer_.record(commands, pass, piece); }});
    if (lit()) {
        steps.push_back({tracer_->map_texels(), [=, this](gpu::CommandList& commands) {
                             tracer_->start(seed_, pass);
                             tracer_->record_map(commands);
                         }});
        light_steps_(pass, steps);
    }
    steps.push_back({0, [this](gpu::CommandList& commands) {
                         merge_.record(commands);
                         frame_.image().record_readback(commands);
                     }});
}

void FirstBounceGpu::add_vpl_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    for (uint32_t piece = 0; importance_ && piece < importance_->pieces(); ++piece)
        steps.push_back({uint64_t{tracer_->map_texels()} * CAMERA_IMPORTANCE_POINTS / importance_->pieces(),
                         [=, this](gpu::CommandList& commands) {
                             importance_->record(commands, tracer_->texels(), tracer_->importance(), pass, piece);
                         }});
    for (uint32_t piece = 0; selection_ && piece < selection_->pieces(); ++piece)
        steps.push_back({selection_->paths_of_piece(),
                         [=, this](gpu::CommandList& commands) { selection_->record(commands, pass, piece); }});
    if (!selection_) steps.push_back({0, [this](gpu::CommandList& commands) { tracer_->record_vpls(commands); }});
}

void FirstBounceGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel,
                              const std::function<bool()>& grows) {
    const StageTimer timer(stats, "indirect");
    if (!frame_.run_with_room(pass, stats, cancel, grows)) return;
    if (lit()) tracer_->add_to(stats.counts);
    if (selection_) selection_->add_to(stats.counts);
}

}  // namespace photond

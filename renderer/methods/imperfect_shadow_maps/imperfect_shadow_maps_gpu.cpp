#include "renderer/methods/imperfect_shadow_maps/imperfect_shadow_maps_gpu.h"
#include "renderer/frame/common_params.h"

#include "protocol/error.h"
#include "renderer/many_lights/first_bounce_gpu.h"
#include "renderer/many_lights/imperfect_shadow_maps.h"
#include "renderer/many_lights/vpl_lighting.h"
#include "renderer/many_lights/vpl_lighting_gpu.h"

namespace photond {

namespace {

FirstBounceSettings settings_of(const ImperfectShadowMapsParams& params) {
    FirstBounceSettings settings = first_bounce_of(params, params.vpls);
    settings.walk.split_side = params.interleave;
    settings.filter = {params.filter, params.filter_normal, params.filter_distance};
    settings.clamp_m2 = params.clamp_m2;
    settings.placement = params.placement;
    settings.tracing.independent_paths = params.placement == VplPlacement::Metropolis;
    return settings;
}

}  // namespace

void ImperfectShadowMapsParams::check() const {
    require_power_of_two("/map_resolution", map_resolution);
    require_power_of_two("/interleave", interleave);
    require_flux_placement(placement);
}

struct ImperfectShadowMapsGpu::State {
    State(const RenderContext& context, const ImperfectShadowMapsParams& params, VplsBetweenFrames& frames,
          Stats& stats)
        : frame(context, settings_of(params), stats, &frames) {
        if (!frame.lit()) return;
        const StageTimer timer(stats, "shadow_maps");
        set.emplace(frame.scene(), params.vpls, params.connect_threshold);
        maps.emplace(frame.scene(), params.shadow_resolution, params.vpls, frame.counters());
        imperfect.emplace(frame.scene(), *maps, params.points);
        lighting.emplace(frame.scene(), frame.buffer(), *set, frame.counters(), frame.seed(),
                         VplLightingSettings{.visibility = VplVisibility::ShadowMaps,
                                             .clamp_sq_m2 = frame.clamp_sq_m2(),
                                             .connect_threshold = params.connect_threshold,
                                             .map_resolution = params.shadow_resolution});
        frame.light_by([this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); });
    }

    void add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
        frame.add_vpl_steps(pass, steps);
        steps.push_back(
            {set->most(), [=, this](gpu::CommandList& commands) {
                 VplTracerGpu& tracer = frame.tracer();
                 set->record(commands, {tracer.state(), tracer.photons(), tracer.order(), tracer.surfaces()});
                 lighting->record_constants(commands, pass);
             }});
        for (uint32_t piece = 0; piece < imperfect->pieces(); ++piece)
            steps.push_back(
                {imperfect->paths_of_piece(), [=, this](gpu::CommandList& commands) {
                     imperfect->record(commands, set->vpls(), {set->counts(), VPL_COUNT}, frame.seed(), pass, piece);
                 }});
        for (uint32_t piece = 0; piece < lighting->pieces(); ++piece)
            steps.push_back({lighting->paths_of_piece(), [=, this](gpu::CommandList& commands) {
                                 lighting->record(commands, {VplVisibility::ShadowMaps, nullptr, &*maps}, piece);
                             }});
    }

    std::optional<VplSetGpu> set;
    std::optional<VplShadowMapsGpu> maps;
    std::optional<ImperfectShadowMaps> imperfect;
    std::optional<VplLightingGpu> lighting;
    FirstBounceGpu frame;  // last: its going waits for work that uses the others
};

ImperfectShadowMapsGpu::ImperfectShadowMapsGpu(const ImperfectShadowMapsParams& params)
    : FollowsFrames(params.incremental, params.vpls), params_(params) {}
ImperfectShadowMapsGpu::~ImperfectShadowMapsGpu() = default;

uint64_t ImperfectShadowMapsGpu::estimate_bytes(const ImperfectShadowMapsParams& params, const Workload& workload) {
    const FirstBounceSettings settings = settings_of(params);
    return FirstBounceGpu::estimate_bytes(settings, workload) +
           VplsBetweenFrames::bytes_for(params.incremental, params.vpls) +
           (FirstBounceGpu::may_be_lit(settings, workload) ? ImperfectShadowMaps::host_bytes(params.points) : 0);
}

uint64_t ImperfectShadowMapsGpu::estimate_device_bytes(const ImperfectShadowMapsParams& params,
                                                       const Workload& workload) {
    const FirstBounceSettings settings = settings_of(params);
    const uint64_t bytes = FirstBounceGpu::estimate_device_bytes(settings, workload);
    if (!FirstBounceGpu::may_be_lit(settings, workload)) return bytes;
    return bytes + VplSetGpu::device_bytes(params.vpls, workload.needs.only_lambert()) +
           VplShadowMapsGpu::device_bytes(params.shadow_resolution, params.vpls) +
           ImperfectShadowMaps::device_bytes(params.shadow_resolution, params.vpls, params.points) +
           VplLightingGpu::device_bytes();
}

void ImperfectShadowMapsGpu::begin(const RenderContext& context, Stats& stats) {
    context.budget.require("occluder_points", ImperfectShadowMaps::host_bytes(params_.points));
    state_ = std::make_unique<State>(context, params_, frames_, stats);
    if (state_->imperfect)  // on their way to the device
        context.budget.record("occluder_points", ImperfectShadowMaps::host_bytes(params_.points));
}

void ImperfectShadowMapsGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    state_->frame.run_pass(pass, stats, cancel);
}
DeviceFrame& ImperfectShadowMapsGpu::frame() { return state_->frame.frame(); }

}  // namespace photond

#include "renderer/methods/reflective_shadow_maps/reflective_shadow_maps_gpu.h"
#include "renderer/frame/common_params.h"

#include "protocol/error.h"
#include "renderer/core/rng.h"
#include "renderer/many_lights/first_bounce_gpu.h"
#include "renderer/many_lights/vpl_lighting.h"
#include "renderer/many_lights/vpl_lighting_gpu.h"
#include "renderer/methods/reflective_shadow_maps/rsm_shared.h"

namespace photond {

namespace {

FirstBounceSettings settings_of(const ReflectiveShadowMapsParams& params) {
    FirstBounceSettings settings = first_bounce_of(params, params.samples);
    settings.clamp_m2 = params.clamp_m2;
    return settings;
}

}  // namespace

void ReflectiveShadowMapsParams::check() const {
    require_power_of_two("/map_resolution", map_resolution);
    if (incremental.on && pattern != RsmPattern::Flux)
        throw Error(ErrorCode::OutOfRange, "/incremental", "incremental goes with pattern flux alone");
}

struct ReflectiveShadowMapsGpu::State {
    State(const RenderContext& context, const ReflectiveShadowMapsParams& p, VplsBetweenFrames& frames, Stats& stats)
        : params(p), frame(context, settings_of(p), stats, &frames) {
        if (!frame.lit()) return;
        const StageTimer timer(stats, "pipelines");
        if (params.pattern == RsmPattern::Flux) {
            set.emplace(frame.scene(), params.samples, params.connect_threshold);
            lighting.emplace(frame.scene(), frame.buffer(), *set, frame.counters(), frame.seed(),
                             VplLightingSettings{.visibility = VplVisibility::None,
                                                 .clamp_sq_m2 = frame.clamp_sq_m2(),
                                                 .connect_threshold = params.connect_threshold});
        } else {
            gather.emplace(frame.scene().device(), "renderer/methods/reflective_shadow_maps/rsm_gather.comp",
                           sizeof(gpu::RsmGatherPush), &frame.scene().set(), frame.scene().specialization());
        }
        frame.light_by([this](uint32_t pass, DeviceFrame::Steps& steps) {
            params.pattern == RsmPattern::Flux ? add_flux_steps(pass, steps) : add_paper_steps(pass, steps);
        });
    }

    void add_flux_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_paper_steps(uint32_t pass, DeviceFrame::Steps& steps);

    const ReflectiveShadowMapsParams& params;
    std::optional<VplSetGpu> set;
    std::optional<VplLightingGpu> lighting;
    std::optional<gpu::ComputePipeline> gather;
    FirstBounceGpu frame;  // last: its going waits for work that uses the others
};

void ReflectiveShadowMapsGpu::State::add_flux_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    steps.push_back({set->most(), [=, this](gpu::CommandList& commands) {
                         VplTracerGpu& tracer = frame.tracer();
                         tracer.record_vpls(commands);
                         set->record(commands, {tracer.state(), tracer.photons(), tracer.order(), tracer.surfaces()});
                         lighting->record_constants(commands, pass);
                     }});
    for (uint32_t piece = 0; piece < lighting->pieces(); ++piece)
        steps.push_back({lighting->paths_of_piece(), [=, this](gpu::CommandList& commands) {
                             lighting->record(commands, {VplVisibility::None, nullptr, nullptr}, piece);
                         }});
}

void ReflectiveShadowMapsGpu::State::add_paper_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    constexpr uint32_t kTexelsAPath = 16;  // that cost a device what a path does
    constexpr uint64_t kKeyStream = 2;
    const uint32_t key = RandomStream(frame.seed(), RandomDomain::Splats, pass, kKeyStream).next_bits();
    const uint32_t points = frame.buffer().layout().points();
    const uint32_t paths = frame.scene().device().paths_per_submit();
    const uint32_t at_once =
        std::max(static_cast<uint32_t>(uint64_t{kTexelsAPath} * paths / params.samples / RSM_GROUP), 1u) * RSM_GROUP;
    for (uint32_t first = 0; first < points; first += at_once)
        steps.push_back({uint64_t{at_once} * params.samples / kTexelsAPath, [=, this](gpu::CommandList& commands) {
                             const gpu::Scope scope(commands, "indirect");
                             GBufferGpu& buffer = frame.buffer();
                             VplTracerGpu& tracer = frame.tracer();
                             commands.bind(
                                 *gather,
                                 {gpu::read("points", buffer.points()), gpu::read("general_points", buffer.general()),
                                  gpu::read("texels", tracer.texels()), gpu::read("texel_runs", tracer.runs()),
                                  gpu::read_write("sums", buffer.sums())});
                             const uint32_t end = std::min(first + at_once, points);
                             commands.push(gpu::RsmGatherPush{.first_point = first,
                                                              .end_point = end,
                                                              .runs = tracer.run_count(),
                                                              .samples = params.samples,
                                                              .key = key,
                                                              .sample_radius = params.sample_radius,
                                                              .clamp_sq_m2 = frame.clamp_sq_m2(),
                                                              .glossy_threshold = params.glossy_threshold});
                             commands.dispatch_threads(end - first, RSM_GROUP);
                         }});
}

ReflectiveShadowMapsGpu::ReflectiveShadowMapsGpu(const ReflectiveShadowMapsParams& params)
    : FollowsFrames(params.incremental, params.samples), params_(params) {}
ReflectiveShadowMapsGpu::~ReflectiveShadowMapsGpu() = default;

uint64_t ReflectiveShadowMapsGpu::estimate_bytes(const ReflectiveShadowMapsParams& params, const Workload& workload) {
    return FirstBounceGpu::estimate_bytes(settings_of(params), workload) +
           VplsBetweenFrames::bytes_for(params.incremental, params.samples);
}

uint64_t ReflectiveShadowMapsGpu::estimate_device_bytes(const ReflectiveShadowMapsParams& params,
                                                        const Workload& workload) {
    const FirstBounceSettings settings = settings_of(params);
    const uint64_t bytes = FirstBounceGpu::estimate_device_bytes(settings, workload);
    if (params.pattern != RsmPattern::Flux || !FirstBounceGpu::may_be_lit(settings, workload)) return bytes;
    return bytes + VplSetGpu::device_bytes(params.samples, workload.needs.only_lambert()) +
           VplLightingGpu::device_bytes();
}

void ReflectiveShadowMapsGpu::begin(const RenderContext& context, Stats& stats) {
    state_ = std::make_unique<State>(context, params_, frames_, stats);
}

void ReflectiveShadowMapsGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    state_->frame.run_pass(pass, stats, cancel);
}
DeviceFrame& ReflectiveShadowMapsGpu::frame() { return state_->frame.frame(); }

}  // namespace photond

#include "renderer/methods/light_propagation_volumes/light_propagation_volumes_gpu.h"

#include <algorithm>

#include "renderer/many_lights/first_bounce_gpu.h"
#include "renderer/methods/light_propagation_volumes/propagation_volumes_gpu.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/bsdf_albedo_table.h"

namespace photond {

namespace {

FirstBounceSettings settings_of(const LightPropagationVolumesParams& params) {
    FirstBounceSettings settings = first_bounce_of(params, params.vpls);
    settings.clamp_m2 = 0;  // nothing is connected
    return settings;
}

uint32_t most_photons(const LightPropagationVolumesParams& params) {
    return static_cast<uint32_t>(most_vpls(params.vpls, params.bounces));
}

}  // namespace

void LightPropagationVolumesParams::check() const { require_power_of_two("/map_resolution", map_resolution); }

struct LightPropagationVolumesGpu::State {
    /// What there is where light is.
    struct Lit {
        Lit(const RenderContext& context, const LightPropagationVolumesParams& params)
            : scene(*context.device_scene),
              volumes(scene,
                      make_propagation_cascades(scene.scene().bounds, context.view.camera, params.resolution,
                                                params.cascades),
                      most_photons(params)),
              albedos(gpu::make_buffer<vec2>(scene.device(), "lobe_albedos", AlbedoTable::unraised().device_data())),
              light(scene.device(), "renderer/methods/light_propagation_volumes/volume_light.comp",
                    sizeof(gpu::VolumeLightPush), &scene.set(),
                    scene.specialization(
                        std::vector{gpu::specialize(ASKS_CELLS_ID, params.receiver_rays && params.geometry_volume)})) {
            if (context.view.layers.has(Layer::Volume))
                show.emplace(scene.device(), "renderer/methods/light_propagation_volumes/volume_layer.comp",
                             sizeof(gpu::SplitRecord), &scene.set(), scene.specialization());
        }

        const gpu::DeviceScene& scene;
        PropagationVolumesGpu volumes;
        gpu::Buffer albedos;
        gpu::ComputePipeline light;
        std::optional<gpu::ComputePipeline> show;
    };

    State(const RenderContext& context, const LightPropagationVolumesParams& p, Stats& stats)
        : params(p), frame(context, settings_of(p), stats) {
        if (!frame.lit()) return;
        {
            const StageTimer timer(stats, "pipelines");
            lit.emplace(context, params);
        }
        lit->volumes.find_faces(params.geometry_volume, stats);
        frame.light_by([this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); });
    }

    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void record_light(gpu::CommandList& commands, uint32_t first, uint32_t end);
    void record_layer(gpu::CommandList& commands);

    const LightPropagationVolumesParams& params;
    std::optional<Lit> lit;  // null: there is no indirect light
    FirstBounceGpu frame;    // last: its going waits for work that uses the others
};

void LightPropagationVolumesGpu::State::add_steps(uint32_t /*pass*/, DeviceFrame::Steps& steps) {
    steps.push_back({expected_vpls(params.vpls, params.bounces), [this](gpu::CommandList& commands) {
                         frame.tracer().record_vpls(commands);
                         for (uint32_t i = 0; i < params.cascades; ++i)
                             lit->volumes.record_injection(commands, frame.tracer(), i);
                     }});
    constexpr uint64_t kCellsAPath = 8;  // a step of that many costs a device what a path does
    const uint64_t cost = lit->volumes.cascades().cells / kCellsAPath + 1;
    const auto at_once =
        static_cast<uint32_t>(std::clamp<uint64_t>(frame.scene().device().paths_per_submit() / cost, 1, params.steps));
    for (uint32_t cascade = 0; cascade < params.cascades; ++cascade)
        for (uint32_t first = 0; first < params.steps; first += at_once) {
            const uint32_t end = std::min(first + at_once, params.steps);
            steps.push_back({cost * (end - first), [=, this](gpu::CommandList& commands) {
                                 lit->volumes.record_steps(commands, cascade, first, end);
                             }});
        }
    const uint32_t points = frame.buffer().layout().points();
    const auto points_at_once =
        static_cast<uint32_t>(std::min<uint64_t>(frame.scene().device().paths_per_submit(), points));
    for (uint32_t first = 0; first < points; first += points_at_once)
        steps.push_back({points_at_once, [=, this](gpu::CommandList& commands) {
                             record_light(commands, first, std::min(first + points_at_once, points));
                         }});
    if (lit->show) steps.push_back({points, [this](gpu::CommandList& commands) { record_layer(commands); }});
}

void LightPropagationVolumesGpu::State::record_light(gpu::CommandList& commands, uint32_t first, uint32_t end) {
    const gpu::Scope scope(commands, "gather");
    GBufferGpu& buffer = frame.buffer();
    commands.bind(lit->light,
                  {gpu::read("cascades", lit->volumes.constants()), gpu::read("injected", lit->volumes.injected()),
                   gpu::read("volume", lit->volumes.volume()), gpu::read("lobe_albedo_table", lit->albedos),
                   gpu::read("points", buffer.points()), gpu::read("general_points", buffer.general()),
                   gpu::read("open_faces", lit->volumes.open_faces()), gpu::write("sums", buffer.sums())});
    commands.push(gpu::VolumeLightPush{first, end, params.glossy_threshold});
    commands.dispatch_threads(end - first, PROPAGATION_GROUP);
}

void LightPropagationVolumesGpu::State::record_layer(gpu::CommandList& commands) {
    GBufferGpu& buffer = frame.buffer();
    commands.bind(*lit->show,
                  {gpu::read_write("device_layers", frame.frame().image().layers()),
                   gpu::read("points", buffer.points()), gpu::read("sums", buffer.sums()),
                   gpu::read("cascades", lit->volumes.constants()), gpu::read("injected", lit->volumes.injected()),
                   gpu::read("volume", lit->volumes.volume()), gpu::read("open_faces", lit->volumes.open_faces())});
    commands.push(buffer.split());
    commands.dispatch_threads(buffer.layout().size.pixels(), SPLIT_GROUP);
}

LightPropagationVolumesGpu::LightPropagationVolumesGpu(const LightPropagationVolumesParams& params) : params_(params) {}
LightPropagationVolumesGpu::~LightPropagationVolumesGpu() = default;

uint64_t LightPropagationVolumesGpu::estimate_bytes(const LightPropagationVolumesParams& params,
                                                    const Workload& workload) {
    return FirstBounceGpu::estimate_bytes(settings_of(params), workload);
}

uint64_t LightPropagationVolumesGpu::estimate_device_bytes(const LightPropagationVolumesParams& params,
                                                           const Workload& workload) {
    const FirstBounceSettings settings = settings_of(params);
    const uint64_t bytes = FirstBounceGpu::estimate_device_bytes(settings, workload);
    if (!FirstBounceGpu::may_be_lit(settings, workload)) return bytes;
    // Nothing is known of the scene's sides: rooms are less high than long.
    Bounds3 room;
    room.extend(vec3(0)), room.extend(vec3(1, 0.75f, 1));
    return bytes + PropagationVolumesGpu::device_bytes(
                       make_propagation_cascades(room, {}, params.resolution, params.cascades), most_photons(params));
}

void LightPropagationVolumesGpu::begin(const RenderContext& context, Stats& stats) {
    state_ = std::make_unique<State>(context, params_, stats);
}

void LightPropagationVolumesGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    state_->frame.run_pass(pass, stats, cancel);
}
DeviceFrame& LightPropagationVolumesGpu::frame() { return state_->frame.frame(); }

}  // namespace photond

#include "renderer/methods/voxel_cone_tracing/voxel_cone_tracing_gpu.h"

#include <algorithm>
#include <numbers>

#include "renderer/core/rng.h"
#include "renderer/many_lights/first_bounce_gpu.h"
#include "renderer/methods/voxel_cone_tracing/cone_tree_gpu.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/bsdf_albedo_table.h"

namespace photond {

namespace {

FirstBounceSettings settings_of(const VoxelConeTracingParams& params) {
    FirstBounceSettings settings = first_bounce_of(params, params.vpls);
    settings.clamp_m2 = 0;  // nothing is connected
    return settings;
}

uint32_t most_photons(const VoxelConeTracingParams& params) {
    return static_cast<uint32_t>(most_vpls(params.vpls, params.bounces));
}

}  // namespace

void VoxelConeTracingParams::check() const {
    require_power_of_two("/map_resolution", map_resolution);
    require_power_of_two("/voxel_resolution", voxel_resolution);
}

struct VoxelConeTracingGpu::State {
    /// What there is where light is.
    struct Lit {
        Lit(const RenderContext& context, const VoxelConeTracingParams& params, Stats& stats)
            : tree(*context.device_scene, make_voxel_grid(context.scene.bounds, params.voxel_resolution),
                   most_photons(params), stats, context.kept_voxels),
              albedos(gpu::make_buffer<vec2>(context.device_scene->device(), "lobe_albedos",
                                             AlbedoTable::unraised().device_data())),
              light(context.device_scene->device(), "renderer/methods/voxel_cone_tracing/cone_light.comp",
                    sizeof(gpu::ConeLightPush), &context.device_scene->set(),
                    context.device_scene->specialization(
                        std::vector{gpu::specialize(EVERY_CELL_ID, params.cells == ConeCells::All),
                                    gpu::specialize(DRAWN_CONES_ID, params.directions == ConeDirections::Drawn)})) {
            if (context.view.layers.has(Layer::ConeMip))
                show.emplace(context.device_scene->device(), "renderer/methods/voxel_cone_tracing/cone_layer.comp",
                             sizeof(gpu::ConeMarch));
        }

        ConeTreeGpu tree;
        gpu::Buffer albedos;
        gpu::ComputePipeline light;
        std::optional<gpu::ComputePipeline> show;
    };

    State(const RenderContext& context, const VoxelConeTracingParams& p, Stats& stats)
        : params(p), frame(context, settings_of(p), stats) {
        if (!frame.lit()) return;
        lit.emplace(context, params, stats);
        frame.light_by([this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); });
    }

    gpu::ConeMarch march_of(uint32_t pass) const;
    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void record_light(gpu::CommandList& commands, uint32_t pass, uint32_t first, uint32_t end);
    void record_layer(gpu::CommandList& commands, uint32_t pass);

    const VoxelConeTracingParams& params;
    std::optional<Lit> lit;  // null: there is no indirect light
    FirstBounceGpu frame;    // last: its going waits for work that uses the others
};

gpu::ConeMarch VoxelConeTracingGpu::State::march_of(uint32_t pass) const {
    constexpr uint64_t kTurnStream = 4;
    return {.aperture = 2 * std::tan(params.aperture_degrees * std::numbers::pi_v<float> / 360),
            .step = params.step,
            .start = params.start_voxels,
            .gloss = params.gloss_aperture,
            .glossy_threshold = params.glossy_threshold,
            .key = RandomStream(frame.seed(), RandomDomain::Splats, pass, kTurnStream).next_bits()};
}

void VoxelConeTracingGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    steps.push_back({expected_vpls(params.vpls, params.bounces), [this](gpu::CommandList& commands) {
                         frame.tracer().record_vpls(commands);
                         lit->tree.record(commands, frame.tracer());
                     }});
    const uint64_t paths_a_point = params.cells == ConeCells::All ? 32 : 2;  // that cost a device what its cones do
    const uint32_t points = frame.buffer().layout().points();
    const uint64_t paths = frame.scene().device().paths_per_submit();
    const auto at_once = static_cast<uint32_t>(std::clamp<uint64_t>(paths / paths_a_point, 1, points));
    for (uint32_t first = 0; first < points; first += at_once)
        steps.push_back({at_once * paths_a_point, [=, this](gpu::CommandList& commands) {
                             record_light(commands, pass, first, std::min(first + at_once, points));
                         }});
    if (lit->show) steps.push_back({points, [=, this](gpu::CommandList& commands) { record_layer(commands, pass); }});
}

void VoxelConeTracingGpu::State::record_light(gpu::CommandList& commands, uint32_t pass, uint32_t first, uint32_t end) {
    const gpu::Scope scope(commands, "gather");
    GBufferGpu& buffer = frame.buffer();
    std::vector<gpu::Binding> bindings = {
        gpu::read("lobe_albedo_table", lit->albedos), gpu::read("points", buffer.points()),
        gpu::read("general_points", buffer.general()), gpu::write("sums", buffer.sums())};
    lit->tree.append_lit_to(bindings);
    commands.bind(lit->light, bindings);
    commands.push(gpu::ConeLightPush{march_of(pass), first, end});
    commands.dispatch_threads(end - first, CONE_GROUP);
}

void VoxelConeTracingGpu::State::record_layer(gpu::CommandList& commands, uint32_t pass) {
    std::vector<gpu::Binding> bindings = {gpu::read_write("device_layers", frame.frame().image().layers()),
                                          gpu::read("eye", frame.buffer().eye())};
    lit->tree.append_lit_to(bindings);
    commands.bind(*lit->show, bindings);
    commands.push(march_of(pass));
    commands.dispatch_threads(frame.buffer().layout().size.pixels(), CONE_GROUP);
}

VoxelConeTracingGpu::VoxelConeTracingGpu(const VoxelConeTracingParams& params) : params_(params) {}
VoxelConeTracingGpu::~VoxelConeTracingGpu() = default;

uint64_t VoxelConeTracingGpu::estimate_bytes(const VoxelConeTracingParams& params, const Workload& workload) {
    return FirstBounceGpu::estimate_bytes(settings_of(params), workload);
}

uint64_t VoxelConeTracingGpu::estimate_device_bytes(const VoxelConeTracingParams& params, const Workload& workload) {
    const FirstBounceSettings settings = settings_of(params);
    const uint64_t bytes = FirstBounceGpu::estimate_device_bytes(settings, workload);
    if (!FirstBounceGpu::may_be_lit(settings, workload)) return bytes;
    return bytes + ConeTreeGpu::guess_device_bytes(params.voxel_resolution, most_photons(params), workload.triangles);
}

void VoxelConeTracingGpu::begin(const RenderContext& context, Stats& stats) {
    state_ = std::make_unique<State>(context, params_, stats);
}

void VoxelConeTracingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.frame.run_pass(pass, stats, cancel, [&] { return state.lit && state.lit->tree.settle(stats); });
}
DeviceFrame& VoxelConeTracingGpu::frame() { return state_->frame.frame(); }

}  // namespace photond

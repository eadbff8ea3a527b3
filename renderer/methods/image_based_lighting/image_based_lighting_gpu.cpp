#include "renderer/methods/image_based_lighting/image_based_lighting_gpu.h"

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/frame/device_frame.h"
#include "renderer/methods/image_based_lighting/image_based_lighting_shared.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/bsdf_albedo_table.h"
#include "renderer/transport/environment_sampling.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

/// What the device is sent: the maps of the environment, or nothing.
struct PrefilteredData {
    gpu::PrefilterConstants constants{};
    std::vector<Rgb> nodes;
};

PrefilteredData make_prefiltered_data(const RenderContext& context, const ImageBasedLightingParams& params,
                                      Stats& stats) {
    const std::optional<Environment>& environment = context.scene.environment;
    if (!environment) return {};
    const EnvironmentSampler sampler(*environment);
    context.budget.record("environment_sampler", sampler.bytes());
    const PrefilteredEnvironment maps = prefilter_environment(context.scene, sampler, params, context.budget, stats);
    return {maps.constants(), {maps.nodes().begin(), maps.nodes().end()}};
}

}  // namespace

struct ImageBasedLightingGpu::State {
    State(const RenderContext& context, SamplerKind sampler, const PrefilteredData& data)
        : device(context.device_scene->device()),
          seed(context.seed),
          sampler_kind(sampler),
          tiles(eye_tile_count(context.view.film_size)),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          pass_sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          constants(gpu::make_buffer(device, "prefiltered_environment", std::span(&data.constants, 1))),
          nodes(gpu::make_buffer(device, "prefiltered_environment", std::span(data.nodes))),
          albedos(gpu::make_buffer<vec2>(device, "lobe_albedos", AlbedoTable::unraised().device_data())),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }),
          pipeline(device, "renderer/methods/image_based_lighting/image_based_lighting.comp",
                   sizeof(gpu::ImageBasedLightingPush), &context.device_scene->set(),
                   context.device_scene->specialization()) {
        const gpu::EyeConstants of_view = make_eye_constants(context.view, kImageBasedScatterings, ROULETTE_START);
        gpu::upload(device, eye, std::as_bytes(std::span(&of_view, 1)));
    }
    ~State() { frame.end(); }

    void add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
        const uint32_t at_once = eye_tiles_at_once(tiles, device.paths_per_submit());
        for (uint32_t first = 0; first < tiles; first += at_once) {
            const uint32_t end = std::min(first + at_once, tiles);
            steps.push_back({uint64_t{end - first} * kEyeTilePixels,
                             [=, this](gpu::CommandList& commands) { record(commands, pass, first, end); }});
        }
        steps.push_back({0, [this](gpu::CommandList& commands) { frame.image().record_readback(commands); }});
    }

    void record(gpu::CommandList& commands, uint32_t pass, uint32_t first, uint32_t end) {
        if (first == 0)
            commands.update(pass_sampler, PassSampler(sampler_kind, seed, RandomDomain::Camera, pass).device_data());
        const gpu::Scope scope(commands, "direct");
        commands.bind(pipeline, {gpu::read_write("device_layers", frame.image().layers()),
                                 gpu::read_write("device_counters", frame.image().counters()), gpu::read("eye", eye),
                                 gpu::read("pass_sampler", pass_sampler), gpu::read("prefilter", constants),
                                 gpu::read("prefilter_nodes", nodes), gpu::read("lobe_albedo_table", albedos)});
        commands.push(gpu::ImageBasedLightingPush{first, end});
        commands.dispatch_threads(uint64_t{end - first} * kEyeTilePixels, kEyeTilePixels);
    }

    gpu::Device& device;
    const uint64_t seed;
    const SamplerKind sampler_kind;
    const uint32_t tiles;
    gpu::Buffer eye, pass_sampler, constants, nodes, albedos;
    DeviceFrame frame;
    gpu::ComputePipeline pipeline;
};

ImageBasedLightingGpu::ImageBasedLightingGpu(const ImageBasedLightingParams& params) : params_(params) {}
ImageBasedLightingGpu::~ImageBasedLightingGpu() = default;

uint64_t ImageBasedLightingGpu::estimate_bytes(const ImageBasedLightingParams& params, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload) + EnvironmentSampler::bytes_for(workload.environment_size) +
           prefilter_bytes(params, workload.environment_size);
}

uint64_t ImageBasedLightingGpu::estimate_device_bytes(const ImageBasedLightingParams& params,
                                                      const Workload& workload) {
    const bool lit = workload.environment_size.pixels() > 0;
    return DeviceFrame::estimate_device_bytes(workload) + sizeof(gpu::EyeConstants) + sizeof(gpu::PassSamplerData) +
           sizeof(gpu::PrefilterConstants) + (lit ? PrefilteredEnvironment::bytes_for(prefilter_of(params)) : 0) +
           AlbedoTable::device_bytes();
}

void ImageBasedLightingGpu::begin(const RenderContext& context, Stats& stats) {
    const PrefilteredData data = make_prefiltered_data(context, params_, stats);
    {
        const StageTimer timer(stats, "pipelines");
        state_ = std::make_unique<State>(context, params_.sampler, data);
    }
    note_skipped_shading(context.scene.needs, stats);
    note_skipped_by_image_based_lighting(context.scene, params_, stats);
}

void ImageBasedLightingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    const StageTimer timer(stats, "direct");
    if (state_->frame.run(pass, stats, cancel)) state_->frame.read(stats);
}

DeviceFrame& ImageBasedLightingGpu::frame() { return state_->frame; }

}  // namespace photond

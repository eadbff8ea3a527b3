#include "renderer/methods/path_tracing/path_tracing_gpu.h"

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/eye/path_wavefront_gpu.h"
#include "renderer/frame/device_frame.h"
#include "renderer/methods/path_tracing/path_tracing_shared.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/light_tables_shared.h"

namespace photond {

namespace {

constexpr std::string_view kShader = "renderer/methods/path_tracing/path_tracing.comp";

}  // namespace

struct PathTracingGpu::State {
    State(const RenderContext& context, const PathTracingParams& params)
        : device(context.device_scene->device()),
          size(context.view.film_size),
          seed(context.seed),
          sampler_kind(params.sampler),
          tiles(eye_tile_count(size)),
          tiles_a_piece(eye_tiles_at_once(tiles, device.paths_per_submit())),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }) {
        const gpu::EyeConstants eye_constants =
            make_eye_constants(context.view, params.max_scatterings(), params.roulette_start);
        gpu::upload(device, eye, std::as_bytes(std::span(&eye_constants, 1)));
        const gpu::DeviceScene& on_device = *context.device_scene;
        const std::vector<gpu::Specialization> constants = on_device.specialization(
            std::vector{gpu::specialize(LIGHT_SAMPLES_COMPENSATED_ID, true)});  // as PathScene on the CPU
        if (params.gpu_kernels == PathKernels::Wavefront)
            wavefront.emplace(on_device, tiles_a_piece, constants);
        else
            megakernel.emplace(device, kShader, sizeof(gpu::PathTracingPush), &on_device.set(), constants);
    }

    void add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
        steps.push_back({0, [=, this](gpu::CommandList& commands) {
                             commands.update(sampler,
                                             PassSampler(sampler_kind, seed, RandomDomain::Camera, pass).device_data());
                         }});
        for (uint32_t first = 0; first < tiles; first += tiles_a_piece) {
            const uint32_t end = std::min(first + tiles_a_piece, tiles);
            steps.push_back({uint64_t{end - first} * kEyeTilePixels,
                             [=, this](gpu::CommandList& commands) { record_paths(first, end, commands); }});
        }
        steps.push_back({0, [this](gpu::CommandList& commands) { frame.image().record_readback(commands); }});
    }

    void record_paths(uint32_t first, uint32_t end, gpu::CommandList& commands) {
        DeviceImage& image = frame.image();
        if (wavefront) {
            wavefront->record(commands, {image, eye, sampler}, first, end);
        } else {
            const gpu::Scope scope(commands, "indirect");
            commands.bind(*megakernel, {gpu::read_write("device_layers", image.layers()),
                                        gpu::read_write("device_counters", image.counters()), gpu::read("eye", eye),
                                        gpu::read("pass_sampler", sampler)});
            commands.push(gpu::PathTracingPush{first, end});
            commands.dispatch_threads(uint64_t{end - first} * kEyeTilePixels, kEyeTilePixels);
        }
    }

    gpu::Device& device;
    const Size2 size;
    const uint64_t seed;
    const SamplerKind sampler_kind;
    const uint32_t tiles, tiles_a_piece;
    gpu::Buffer eye, sampler;
    std::optional<gpu::ComputePipeline> megakernel;
    std::optional<PathWavefrontGpu> wavefront;
    DeviceFrame frame;  // last: its going waits for work that uses the others
};

PathTracingGpu::PathTracingGpu(const PathTracingParams& params) : params_(params) {}
PathTracingGpu::~PathTracingGpu() = default;

uint64_t PathTracingGpu::estimate_bytes(const PathTracingParams& /*params*/, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload);
}

uint64_t PathTracingGpu::estimate_device_bytes(const PathTracingParams& params, const Workload& workload) {
    uint64_t bytes =
        DeviceFrame::estimate_device_bytes(workload) + sizeof(gpu::PassSamplerData) + sizeof(gpu::EyeConstants);
    if (params.gpu_kernels == PathKernels::Wavefront)
        bytes += PathWavefrontGpu::device_bytes(
            eye_tiles_at_once(eye_tile_count(workload.film_size), gpu::Device::kMostPathsPerSubmit));
    return bytes;
}

void PathTracingGpu::begin(const RenderContext& context, Stats& stats) {
    {
        const StageTimer timer(stats, "pipelines");
        state_ = std::make_unique<State>(context, params_);
    }
    const Needs& needs = context.scene.needs;
    note_skipped_shading(needs, stats);
    if (!needs.alpha) stats.skipped.push_back({"alpha test of rays", "no surface is masked or blended", 0});
}

void PathTracingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    const StageTimer timer(stats, "indirect");
    if (state_->frame.run(pass, stats, cancel)) state_->frame.read(stats);
}

DeviceFrame& PathTracingGpu::frame() { return state_->frame; }

}  // namespace photond

#include "renderer/methods/path_tracing/path_tracing_gpu.h"

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/frame/device_image.h"
#include "renderer/frame/device_passes.h"
#include "renderer/methods/path_tracing/path_tracing_shared.h"
#include "renderer/methods/path_tracing/path_wavefront_gpu.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr std::string_view kShader = "renderer/methods/path_tracing/path_tracing.comp";
constexpr uint32_t kTilePixels = EYE_TILE * EYE_TILE;

}  // namespace

struct PathTracingGpu::State {
    State(const RenderContext& context, const PathTracingParams& params, Kernels kernels)
        : device(context.device_scene->device()),
          scene(context.scene),
          size(context.view.film_size),
          seed(context.seed),
          sampler(params.sampler),
          tiles((size.width + EYE_TILE - 1) / EYE_TILE * ((size.height + EYE_TILE - 1) / EYE_TILE)),
          tiles_a_piece(std::max(device.paths_per_submit() / kTilePixels, 1u)),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          image(size, context.view.layers) {
        for (Slot& slot : slots)
            slot = {DeviceImage(device, size, context.view.layers),
                    gpu::Buffer(device, "sampler", sizeof(gpu::PassSamplerData))};
        const gpu::EyeConstants eye_constants =
            make_eye_constants(context.view, params.max_scatterings(), params.roulette_start);
        gpu::upload(device, eye, std::as_bytes(std::span(&eye_constants, 1)));
        const gpu::DeviceScene& on_device = *context.device_scene;
        const std::vector<gpu::Specialization> constants = on_device.specialization(slots[0].image.specialization());
        if (kernels == Kernels::Wavefront)
            wavefront.emplace(on_device, std::min(tiles, tiles_a_piece), constants);
        else
            megakernel.emplace(device, kShader, sizeof(gpu::PathTracingPush), &on_device.set(), constants);
        passes.emplace(device, (tiles + tiles_a_piece - 1) / tiles_a_piece,
                       [this](uint32_t pass, uint32_t slot, uint32_t piece, gpu::CommandList& commands) {
                           record(pass, slots[slot], piece, commands);
                       });
    }

    struct Slot {
        DeviceImage image;
        gpu::Buffer sampler;
    };

    void record(uint32_t pass, Slot& slot, uint32_t piece, gpu::CommandList& commands) {
        if (piece == 0) {
            slot.image.record_clear(commands);
            const gpu::PassSamplerData numbers = PassSampler(sampler, seed, RandomDomain::Camera, pass).device_data();
            commands.update(slot.sampler, numbers);
        }
        const uint32_t first = piece * tiles_a_piece, end = std::min(first + tiles_a_piece, tiles);
        if (wavefront) {
            wavefront->record(commands, slot.image, eye, slot.sampler, first, end);
        } else {
            const gpu::Scope scope(commands, "indirect");
            commands.bind(*megakernel, {gpu::read_write("device_layers", slot.image.layers()),
                                        gpu::read_write("device_counters", slot.image.counters()),
                                        gpu::read("eye", eye), gpu::read("pass_sampler", slot.sampler)});
            commands.push(gpu::PathTracingPush{first, end});
            commands.dispatch_threads(uint64_t{end - first} * kTilePixels, kTilePixels);
        }
        if (end == tiles) slot.image.record_readback(commands);
    }

    gpu::Device& device;
    const Scene& scene;
    const Size2 size;
    const uint64_t seed;
    const SamplerKind sampler;
    const uint32_t tiles, tiles_a_piece;
    gpu::Buffer eye;
    Slot slots[DevicePasses::kSlots];
    std::optional<gpu::ComputePipeline> megakernel;
    std::optional<PathWavefrontGpu> wavefront;
    PassImage image;
    bool pass_complete = false;          // image holds a whole pass
    std::optional<DevicePasses> passes;  // last: its going waits for work that uses the others
};

PathTracingGpu::PathTracingGpu(const PathTracingParams& params, Kernels kernels) : params_(params), kernels_(kernels) {}
PathTracingGpu::~PathTracingGpu() = default;

uint64_t PathTracingGpu::estimate_bytes(const PathTracingParams& /*params*/, const Workload& workload) {
    return PassImage::bytes_for(workload.film_size, workload.layers);
}

uint64_t PathTracingGpu::estimate_device_bytes(const PathTracingParams& /*params*/, const Workload& workload) {
    return DevicePasses::kSlots *
               (DeviceImage::device_bytes(workload.film_size, workload.layers) +
                DeviceImage::host_bytes(workload.film_size, workload.layers) + sizeof(gpu::PassSamplerData)) +
           sizeof(gpu::EyeConstants);
}

void PathTracingGpu::begin(const RenderContext& context, Stats& stats) {
    const uint64_t image_bytes = PassImage::bytes_for(context.view.film_size, context.view.layers);
    context.budget.require("pass_image", image_bytes);
    {
        const StageTimer timer(stats, "pipelines");
        state_ = std::make_unique<State>(context, params_, kernels_);
    }
    context.budget.record("pass_image", image_bytes);

    const Needs& needs = context.scene.needs;
    if (needs.only_lambert())
        stats.skipped.push_back({"layered shading", "every surface is a plain Lambert reflector", 0});
    if (!needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
    if (!needs.alpha) stats.skipped.push_back({"alpha test of rays", "no surface is masked or blended", 0});
}

void PathTracingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.pass_complete = false;
    const StageTimer timer(stats, "indirect");
    const std::optional<uint32_t> slot = state.passes->run(pass, stats, cancel);
    if (!slot) return;
    state.slots[*slot].image.read(state.image, stats.counts, state.scene.origin);
    state.pass_complete = true;
}

void PathTracingGpu::expect_pass(uint32_t pass) { state_->passes->expect(pass); }
void PathTracingGpu::settle() { state_->passes->settle(); }

void PathTracingGpu::resolve(Film& film) {
    if (state_->pass_complete) film.add_pass(state_->image);
}

}  // namespace photond

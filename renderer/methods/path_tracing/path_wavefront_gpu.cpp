#include "renderer/methods/path_tracing/path_wavefront_gpu.h"

#include "renderer/eye/eye_constants.h"
#include "renderer/methods/path_tracing/path_tracing_shared.h"
#include "renderer/scene/intersector.h"

namespace photond {

namespace {

constexpr uint32_t kPush = sizeof(gpu::PathWavePush);

std::string wave_shader(const char* kernel) {
    return std::string("renderer/methods/path_tracing/path_wave_") + kernel + ".comp";
}

}  // namespace

PathWavefrontGpu::PathWavefrontGpu(const gpu::DeviceScene& scene, uint32_t most_tiles,
                                   std::span<const gpu::Specialization> constants)
    : capacity_(most_tiles * kEyeTilePixels),
      start_(scene.device(), wave_shader("start"), kPush, &scene.set(), constants),
      queue_(scene.device(), wave_shader("queue"), 0),
      extend_(scene.device(), wave_shader("extend"), kPush, &scene.set(), constants),
      shade_(scene.device(), wave_shader("shade"), kPush, &scene.set(), constants),
      shadow_(scene.device(), wave_shader("shadow"), kPush, &scene.set(), constants),
      tail_(scene.device(), wave_shader("tail"), kPush, &scene.set(), constants),
      counts_(scene.device(), "path_queues", PATH_COUNT_WORDS * sizeof(uint32_t)),
      queues_(scene.device(), "path_queues", uint64_t{2} * capacity_ * sizeof(uint32_t)),
      states_(scene.device(), "path_states", uint64_t{capacity_} * sizeof(gpu::PathState)),
      hits_(scene.device(), "path_hits", uint64_t{capacity_} * sizeof(Hit)),
      shadows_(scene.device(), "path_shadows", uint64_t{capacity_} * sizeof(gpu::ShadowState)) {}

uint64_t PathWavefrontGpu::device_bytes(uint32_t most_tiles) {
    const uint64_t paths = uint64_t{most_tiles} * kEyeTilePixels;
    return paths * (2 * sizeof(uint32_t) + sizeof(gpu::PathState) + sizeof(Hit) + sizeof(gpu::ShadowState)) +
           PATH_COUNT_WORDS * sizeof(uint32_t);
}

void PathWavefrontGpu::record(gpu::CommandList& commands, DeviceImage& image, gpu::Buffer& eye, gpu::Buffer& sampler,
                              uint32_t first_tile, uint32_t end_tile, uint32_t vertices) {
    const auto bind = [&](const gpu::ComputePipeline& pipeline, const gpu::PathWavePush& push) {
        commands.bind(pipeline, {gpu::read_write("device_layers", image.layers()),
                                 gpu::read_write("device_counters", image.counters()), gpu::read("eye", eye),
                                 gpu::read("pass_sampler", sampler), gpu::read_write("path_counts", counts_),
                                 gpu::read_write("path_queues", queues_), gpu::read_write("path_states", states_),
                                 gpu::read_write("path_hits", hits_), gpu::read_write("path_shadows", shadows_)});
        commands.push(push);
    };
    const auto turn_queues = [&] {
        commands.bind(queue_, {gpu::read_write("path_counts", counts_)});
        commands.dispatch(1);
    };
    commands.fill(counts_, 0);
    {
        const gpu::Scope scope(commands, "g_buffer");
        bind(start_, {first_tile, end_tile, capacity_});
        commands.dispatch_threads(uint64_t{end_tile - first_tile} * kEyeTilePixels, PATH_QUEUE_GROUP);
        turn_queues();
    }
    for (uint32_t vertex = 0; vertex < vertices; ++vertex) {
        const gpu::Scope scope(commands, vertex == 0 ? "direct" : "indirect");
        const gpu::PathWavePush push{vertex, vertex % 2, capacity_};
        bind(extend_, push);
        commands.dispatch_indirect(counts_, PATH_GROUPS * sizeof(uint32_t));
        bind(shade_, push);
        commands.dispatch_indirect(counts_, PATH_GROUPS * sizeof(uint32_t));
        turn_queues();
        bind(shadow_, push);
        commands.dispatch_indirect(counts_, SHADOW_GROUPS * sizeof(uint32_t));
    }
    const gpu::Scope scope(commands, "indirect");
    bind(tail_, {vertices, vertices % 2, capacity_});
    commands.dispatch_indirect(counts_, PATH_GROUPS * sizeof(uint32_t));
}

}  // namespace photond

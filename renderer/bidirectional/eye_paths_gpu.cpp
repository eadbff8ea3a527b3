#include "renderer/bidirectional/eye_paths_gpu.h"

#include "renderer/eye/eye_shared.h"
#include "renderer/eye/wave_queues_shared.h"

namespace photond {

namespace {

constexpr uint32_t kJoiningPush = sizeof(gpu::PathWavePush);

std::string joining_kernel(const char* kernel) { return std::string("renderer/bidirectional/eye_") + kernel + ".comp"; }

}  // namespace

EyePathsGpu::EyePathsGpu(const gpu::DeviceScene& scene, const PassTechniques& techniques, uint32_t most_tiles,
                         std::span<const gpu::Specialization> constants)
    : wave_(scene, most_tiles, constants),
      shade_(scene.device(), joining_kernel("shade"), kJoiningPush, &scene.set(), constants),
      weights_(scene.device(), "path_states", uint64_t{wave_.capacity()} * sizeof(gpu::SubpathWeights)),
      joins_(scene.device(), "path_joins", uint64_t{wave_.capacity()} * sizeof(gpu::JoinState)),
      host_left_(scene.device(), "readback", sizeof(uint32_t), gpu::MemoryKind::Readback) {
    if (techniques.own_path || techniques.everywhere.connections_per_vertex > 0)
        connect_.emplace(scene.device(), joining_kernel("connect"), kJoiningPush, &scene.set(), constants);
    if (techniques.everywhere.numbers.merges)
        merge_.emplace(scene.device(), joining_kernel("merge"), kJoiningPush, &scene.set(), constants);
}

uint64_t EyePathsGpu::device_bytes(uint32_t most_tiles) {
    const uint64_t paths = uint64_t{most_tiles} * EYE_TILE * EYE_TILE;
    return PathWaveGpu::device_bytes(most_tiles) + paths * (sizeof(gpu::SubpathWeights) + sizeof(gpu::JoinState));
}

void EyePathsGpu::record_vertex(gpu::CommandList& commands, const PathWaveFrame& frame, LightPathsGpu& light,
                                uint32_t vertex) {
    wave_.record_rays(commands, frame, vertex);
    std::vector<gpu::Binding> shading = wave_.bindings(frame);
    shading.insert(shading.end(),
                   {gpu::read_write("path_weights", weights_), gpu::write("joins", joins_),
                    gpu::read("techniques", light.techniques()), gpu::read("grid_starts", light.tables())});
    commands.bind(shade_, shading);
    commands.push(wave_.push(vertex));
    wave_.dispatch(commands, WAVE_PATHS);
    wave_.turn_queues(commands);
    wave_.record_shadow_rays(commands, frame);
    const auto join = [&](const gpu::ComputePipeline& kernel, gpu::Binding more) {
        commands.bind(kernel,
                      {gpu::read_write("device_layers", frame.image.layers()),
                       gpu::read_write("device_counters", frame.image.counters()), gpu::read("eye", frame.eye),
                       gpu::read_write("wave_queues", wave_.queues()), gpu::read("techniques", light.techniques()),
                       gpu::read("joins", joins_), gpu::read("grid_starts", light.tables()),
                       gpu::read("light_vertices", light.vertices()), more});
        commands.push(wave_.push(vertex));
        wave_.dispatch(commands, WAVE_JOINS);
    };
    if (connect_) join(*connect_, gpu::read("light_order", light.order()));
    if (merge_) join(*merge_, gpu::read("grid_places", light.grid_places()));
}

void EyePathsGpu::record_start(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t first_tile,
                               uint32_t end_tile) {
    const gpu::Scope scope(commands, "g_buffer");
    wave_.record_start(commands, frame, first_tile, end_tile);
}

void EyePathsGpu::record_vertices(gpu::CommandList& commands, const PathWaveFrame& frame, LightPathsGpu& light,
                                  uint32_t vertex) {
    for (const uint32_t end = vertex + kVertices; vertex < end; ++vertex) {
        const gpu::Scope scope(commands, vertex == 0 ? "direct" : "indirect");
        record_vertex(commands, frame, light, vertex);
    }
    commands.copy(wave_.queues(), WAVE_NOW(WAVE_PATHS) * sizeof(uint32_t), host_left_, 0, sizeof(uint32_t));
    commands.host_reads(host_left_);
}

}  // namespace photond

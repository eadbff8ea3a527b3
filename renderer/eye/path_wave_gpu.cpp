#include "renderer/eye/path_wave_gpu.h"

#include "renderer/eye/eye_constants.h"
#include "renderer/eye/wave_queues_shared.h"
#include "renderer/scene/intersector.h"

namespace photond {

namespace {

constexpr uint32_t kWavePush = sizeof(gpu::PathWavePush);

uint64_t queue_bytes(uint64_t paths) { return (WAVE_COUNT_WORDS + 2 * paths) * sizeof(uint32_t); }

}  // namespace

PathWaveGpu::PathWaveGpu(const gpu::DeviceScene& scene, uint32_t most_tiles,
                         std::span<const gpu::Specialization> constants)
    : capacity_(most_tiles * kEyeTilePixels),
      start_(scene.device(), "renderer/eye/path_wave_start.comp", kWavePush, &scene.set(), constants),
      turn_(scene.device(), "renderer/eye/wave_queues.comp", 0),
      rays_(scene.device(), "renderer/eye/path_wave_extend.comp", kWavePush, &scene.set(), constants),
      shadow_(scene.device(), "renderer/eye/path_wave_shadow.comp", kWavePush, &scene.set(), constants),
      queues_(scene.device(), "path_queues", queue_bytes(capacity_)),
      states_(scene.device(), "path_states", uint64_t{capacity_} * sizeof(gpu::PathState)),
      hits_(scene.device(), "path_hits", uint64_t{capacity_} * sizeof(Hit)),
      shadows_(scene.device(), "path_shadows", uint64_t{capacity_} * sizeof(gpu::ShadowState)) {}

uint64_t PathWaveGpu::device_bytes(uint32_t most_tiles) {
    const uint64_t paths = uint64_t{most_tiles} * kEyeTilePixels;
    return paths * (sizeof(gpu::PathState) + sizeof(Hit) + sizeof(gpu::ShadowState)) + queue_bytes(paths);
}

std::vector<gpu::Binding> PathWaveGpu::bindings(const PathWaveFrame& frame, bool tail) {
    std::vector<gpu::Binding> all{gpu::read_write("device_layers", frame.image.layers()),
                                  gpu::read_write("device_counters", frame.image.counters()),
                                  gpu::read("eye", frame.eye),
                                  gpu::read("pass_sampler", frame.sampler),
                                  gpu::read_write("wave_queues", queues_),
                                  gpu::read_write("path_states", states_)};
    if (!tail) all.insert(all.end(), {gpu::read_write("path_hits", hits_), gpu::read_write("path_shadows", shadows_)});
    return all;
}

void PathWaveGpu::dispatch(gpu::CommandList& commands, uint32_t queue) {
    commands.dispatch_indirect(queues_, WAVE_GROUPS(queue) * sizeof(uint32_t));
}

void PathWaveGpu::turn_queues(gpu::CommandList& commands) {
    commands.bind(turn_, {gpu::read_write("wave_queues", queues_)});
    commands.dispatch(1);
}

void PathWaveGpu::record_start(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t first_tile,
                               uint32_t end_tile) {
    commands.fill(queues_, 0, 0, WAVE_COUNT_WORDS * sizeof(uint32_t));
    commands.bind(start_, bindings(frame));
    commands.push(gpu::PathWavePush{first_tile, end_tile, capacity_});
    commands.dispatch_threads(uint64_t{end_tile - first_tile} * kEyeTilePixels, WAVE_GROUP);
    turn_queues(commands);
}

void PathWaveGpu::record_rays(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t vertex) {
    commands.bind(rays_, bindings(frame));
    commands.push(push(vertex));
    dispatch(commands, WAVE_PATHS);
}

void PathWaveGpu::record_shadow_rays(gpu::CommandList& commands, const PathWaveFrame& frame) {
    commands.bind(shadow_, bindings(frame));
    commands.push(push(0));
    dispatch(commands, WAVE_SHADOWS);
}

}  // namespace photond

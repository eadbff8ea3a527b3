#include "renderer/eye/path_wavefront_gpu.h"

#include "renderer/eye/wave_queues_shared.h"

namespace photond {

PathWavefrontGpu::PathWavefrontGpu(const gpu::DeviceScene& scene, uint32_t most_tiles,
                                   std::span<const gpu::Specialization> constants)
    : wave_(scene, most_tiles, constants),
      shade_(scene.device(), "renderer/eye/path_wave_shade.comp", sizeof(gpu::PathWavePush), &scene.set(), constants),
      tail_(scene.device(), "renderer/eye/path_wave_tail.comp", sizeof(gpu::PathWavePush), &scene.set(), constants) {}

void PathWavefrontGpu::record(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t first_tile,
                              uint32_t end_tile, uint32_t vertices) {
    {
        const gpu::Scope scope(commands, "g_buffer");
        wave_.record_start(commands, frame, first_tile, end_tile);
    }
    for (uint32_t vertex = 0; vertex < vertices; ++vertex) {
        const gpu::Scope scope(commands, vertex == 0 ? "direct" : "indirect");
        wave_.record_rays(commands, frame, vertex);
        commands.bind(shade_, wave_.bindings(frame));
        commands.push(wave_.push(vertex));
        wave_.dispatch(commands, WAVE_PATHS);
        wave_.turn_queues(commands);
        wave_.record_shadow_rays(commands, frame);
    }
    const gpu::Scope scope(commands, "indirect");
    commands.bind(tail_, wave_.bindings(frame, true));
    commands.push(wave_.push(vertices));
    wave_.dispatch(commands, WAVE_PATHS);
}

}  // namespace photond

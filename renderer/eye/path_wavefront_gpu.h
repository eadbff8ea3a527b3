#pragma once
// PathWavefront on a GPU: paths from the eye that light samples are weighed against alone.

#include "renderer/eye/path_wave_gpu.h"

namespace photond {

class PathWavefrontGpu {
public:
    /// For stretches of at most `most_tiles`. `constants`: the scene's and the image's. Borrows the scene.
    PathWavefrontGpu(const gpu::DeviceScene& scene, uint32_t most_tiles,
                     std::span<const gpu::Specialization> constants);
    static uint64_t device_bytes(uint32_t most_tiles) { return PathWaveGpu::device_bytes(most_tiles); }

    /// All paths of the tiles [first_tile, end_tile), from the eye to their ends: `vertices` as a wavefront, what is
    /// left by a thread each. Stages `g_buffer`, `direct` and `indirect`.
    void record(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t first_tile, uint32_t end_tile,
                uint32_t vertices = kVertices);

private:
    static constexpr uint32_t kVertices = 8;

    PathWaveGpu wave_;
    gpu::ComputePipeline shade_, tail_;
};

}  // namespace photond

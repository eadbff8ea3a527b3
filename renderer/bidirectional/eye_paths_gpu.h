#pragma once
// EyePathTracer on a GPU, as a wavefront: rays, surfaces, shadow rays, connections and merging are kernels of their
// own. The same paths with the same numbers, joined with the same light paths.

#include "renderer/bidirectional/light_paths_gpu.h"
#include "renderer/eye/path_wave_gpu.h"

namespace photond {

class EyePathsGpu {
public:
    /// For stretches of at most `most_tiles`. `constants`: the scene's and the image's. Borrows the scene.
    EyePathsGpu(const gpu::DeviceScene& scene, const PassTechniques& techniques, uint32_t most_tiles,
                std::span<const gpu::Specialization> constants);
    static uint64_t device_bytes(uint32_t most_tiles);

    /// The tiles [first_tile, end_tile): a path through each of their pixels is under way. Stage `g_buffer`.
    void record_start(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t first_tile, uint32_t end_tile);
    /// The next vertices of all paths under way, the first one being `vertex`: kVertices of them. Stages `direct` and
    /// `indirect`.
    void record_vertices(gpu::CommandList& commands, const PathWaveFrame& frame, LightPathsGpu& light, uint32_t vertex);
    static constexpr uint32_t kVertices = 8;
    /// Once that has been waited for: paths that are still under way.
    uint32_t paths_left() const { return host_left_.as<const uint32_t>()[0]; }

private:
    void record_vertex(gpu::CommandList& commands, const PathWaveFrame& frame, LightPathsGpu& light, uint32_t vertex);

    PathWaveGpu wave_;
    gpu::ComputePipeline shade_;
    std::optional<gpu::ComputePipeline> connect_, merge_;  // where it is done
    gpu::Buffer weights_, joins_, host_left_;
};

}  // namespace photond

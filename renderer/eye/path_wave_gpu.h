#pragma once
// What wavefronts of paths from the eye have in common on a GPU: paths start, their rays and shadow rays are traced,
// and queues hold those under way; what they do at surfaces is the user's. [Laine, Karras, Aila 2013] Megakernels
// Considered Harmful: Wavefront Path Tracing on GPUs. HPG.

#include <vector>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/eye/path_wavefront_shared.h"
#include "renderer/frame/device_image.h"

namespace photond {

/// What the paths of a pass read, and where they leave their light.
struct PathWaveFrame {
    DeviceImage& image;
    gpu::Buffer& eye;
    gpu::Buffer& sampler;
};

class PathWaveGpu {
public:
    /// For stretches of at most `most_tiles`. `constants`: the scene's and the image's. Borrows the scene.
    PathWaveGpu(const gpu::DeviceScene& scene, uint32_t most_tiles, std::span<const gpu::Specialization> constants);
    static uint64_t device_bytes(uint32_t most_tiles);
    uint32_t capacity() const { return capacity_; }

    /// A path for each pixel of the tiles [first_tile, end_tile).
    void record_start(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t first_tile, uint32_t end_tile);
    /// Where the paths under way meet surfaces; `vertex`: the number of those.
    void record_rays(gpu::CommandList& commands, const PathWaveFrame& frame, uint32_t vertex);
    /// What waits next is what is there now.
    void turn_queues(gpu::CommandList& commands);
    void record_shadow_rays(gpu::CommandList& commands, const PathWaveFrame& frame);

    /// The buffers of a kernel that includes path_wave.glsl; `tail`: with PATH_WAVE_TAIL.
    std::vector<gpu::Binding> bindings(const PathWaveFrame& frame, bool tail = false);
    gpu::PathWavePush push(uint32_t vertex) const { return {vertex, vertex % 2, capacity_}; }
    /// The kernel that is bound, over what is there now of that queue (wave_queues_shared.h).
    void dispatch(gpu::CommandList& commands, uint32_t queue);
    gpu::Buffer& queues() { return queues_; }

private:
    const uint32_t capacity_;
    gpu::ComputePipeline start_, turn_, rays_, shadow_;
    gpu::Buffer queues_, states_, hits_, shadows_;
};

}  // namespace photond

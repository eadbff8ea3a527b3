#pragma once
// Path tracing on a GPU as a wavefront: rays, surfaces and shadow rays are kernels of their own, over queues of the
// paths under way. [Laine, Karras, Aila 2013] Megakernels Considered Harmful: Wavefront Path Tracing on GPUs. HPG.

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/frame/device_image.h"

namespace photond {

class PathWavefrontGpu {
public:
    /// For stretches of at most `most_tiles`. `constants`: the scene's and the image's. Borrows the scene.
    PathWavefrontGpu(const gpu::DeviceScene& scene, uint32_t most_tiles,
                     std::span<const gpu::Specialization> constants);
    static uint64_t device_bytes(uint32_t most_tiles);

    /// All paths of the tiles [first_tile, end_tile), from the eye to their ends: `vertices` as a wavefront, what is
    /// left by a thread each. Stages `g_buffer`, `direct` and `indirect`.
    void record(gpu::CommandList& commands, DeviceImage& image, gpu::Buffer& eye, gpu::Buffer& sampler,
                uint32_t first_tile, uint32_t end_tile, uint32_t vertices = kVertices);

private:
    static constexpr uint32_t kVertices = 8;

    const uint32_t capacity_;
    gpu::ComputePipeline start_, queue_, extend_, shade_, shadow_, tail_;
    gpu::Buffer counts_, queues_, states_, hits_, shadows_;
};

}  // namespace photond

#pragma once
// Float images in which splats are added up as they are drawn, and the buffers that shaders read them from.

#include <memory>
#include <span>
#include <vector>

#include "renderer/backends/gpu/raster_pass.h"
#include "renderer/core/geometry.h"

namespace photond {

/// Channels blend by adding, in the order of the splats: the same bits every time.
class AddedImages {
public:
    /// All of one size, a format each. `structure`: in the accounts of memory.
    AddedImages(gpu::Device& device, const char* structure, std::vector<VkFormat> formats, Size2 size);
    static uint64_t device_bytes(std::span<const VkFormat> formats, Size2 size);

    gpu::RasterOptions options() const;
    /// `clear`: black before the draw.
    gpu::RasterTargets targets(bool clear);
    /// After the last draw: to the buffers.
    void record_copies(gpu::CommandList& commands);
    gpu::Buffer& copy(size_t image) { return copies_[image]; }

private:
    const std::vector<VkFormat> formats_;
    std::vector<std::unique_ptr<gpu::Image>> images_;
    std::vector<gpu::Buffer> copies_;
};

}  // namespace photond

#include "renderer/splats/added_images.h"

namespace photond {

AddedImages::AddedImages(gpu::Device& device, const char* structure, std::vector<VkFormat> formats, Size2 size)
    : formats_(std::move(formats)) {
    for (const VkFormat format : formats_) {
        images_.push_back(std::make_unique<gpu::Image>(device, structure, format, size.width, size.height));
        copies_.emplace_back(device, structure, images_.back()->packed_bytes());
    }
}

uint64_t AddedImages::device_bytes(std::span<const VkFormat> formats, Size2 size) {
    uint64_t bytes = 0;
    for (const VkFormat format : formats) bytes += 2 * size.pixels() * gpu::pixel_bytes(format);
    return bytes;
}

gpu::RasterOptions AddedImages::options() const {
    gpu::RasterOptions options;
    for (const VkFormat format : formats_) options.colors.push_back({format, gpu::Blend::Add});
    return options;
}

gpu::RasterTargets AddedImages::targets(bool clear) {
    gpu::RasterTargets targets;
    for (const std::unique_ptr<gpu::Image>& image : images_)
        targets.colors.push_back(clear ? gpu::clear(*image, std::array<float, 4>{}) : gpu::load(*image));
    return targets;
}

void AddedImages::record_copies(gpu::CommandList& commands) {
    for (size_t i = 0; i < images_.size(); ++i) gpu::copy(commands, *images_[i], copies_[i]);
}

}  // namespace photond

#pragma once
// Images that raster passes draw into (raster_pass.h), and copies between them and buffers: shaders read them there.

#include "renderer/backends/gpu/command_list.h"

namespace photond::gpu {

/// How the commands recorded so far have left an image.
struct ImageState {
    UseState use;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

/// A stack of 2D images, each of which can be drawn into; they are used, and change their layouts, together.
class Image {
public:
    /// `format`: 32-bit floats or uints of one, two or four channels (VK_FORMAT_R32_SFLOAT ... R32G32B32A32_UINT), or
    /// VK_FORMAT_D32_SFLOAT for depth. Throws ErrorCode::Unsupported, naming the format, where the device cannot draw
    /// into it; ErrorCode::OutOfMemory past the device's limit and, with the figures, past its largest image;
    /// ErrorCode::Internal for other formats and for no pixels.
    Image(Device& device, std::string structure, VkFormat format, uint32_t width, uint32_t height, uint32_t layers = 1);
    ~Image();
    Image(const Image&) = delete;
    Image& operator=(const Image&) = delete;

    VkImage handle() const { return handle_; }
    /// One layer as an attachment.
    VkImageView view(uint32_t layer) const { return views_.at(layer); }
    const std::string& structure() const { return structure_; }
    VkFormat format() const { return format_; }
    VkImageAspectFlags aspect() const;
    uint32_t width() const { return width_; }
    uint32_t height() const { return height_; }
    uint32_t layers() const { return static_cast<uint32_t>(views_.size()); }
    /// Of all layers, as buffers hold them: rows from the top, layer after layer, nothing between.
    uint64_t packed_bytes() const;

    ImageState& state() { return state_; }

private:
    void make_views(uint32_t layers);
    void destroy() noexcept;

    Device& device_;
    const std::string structure_;
    const VkFormat format_;
    const uint32_t width_, height_;
    VkImage handle_ = VK_NULL_HANDLE;
    Allocation allocation_;
    std::vector<VkImageView> views_;
    ImageState state_;
};

/// "R32_SFLOAT".
std::string format_name(VkFormat format);
/// Bytes of a pixel; 0 for a format that images here cannot have.
uint32_t pixel_bytes(VkFormat format);
/// What the device can do with images of that format.
VkFormatFeatureFlags format_features(const Device& device, VkFormat format);

/// All layers to packed_bytes() of the buffer from `offset`, a multiple of a pixel's bytes.
void copy(CommandList& commands, Image& from, Buffer& to, uint64_t offset = 0);
/// The other way.
void copy(CommandList& commands, Buffer& from, Image& to, uint64_t offset = 0);

}  // namespace photond::gpu

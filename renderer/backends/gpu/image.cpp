#include "renderer/backends/gpu/image.h"

#include <algorithm>

namespace photond::gpu {

namespace {

struct Format {
    VkFormat format;
    const char* name;
    uint32_t bytes;
};
constexpr Format kFormats[] = {
    {VK_FORMAT_R32_SFLOAT, "R32_SFLOAT", 4},
    {VK_FORMAT_R32G32_SFLOAT, "R32G32_SFLOAT", 8},
    {VK_FORMAT_R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT", 16},
    {VK_FORMAT_R32_UINT, "R32_UINT", 4},
    {VK_FORMAT_R32G32_UINT, "R32G32_UINT", 8},
    {VK_FORMAT_R32G32B32A32_UINT, "R32G32B32A32_UINT", 16},
    {VK_FORMAT_D32_SFLOAT, "D32_SFLOAT", 4},
};

const Format* find_format(VkFormat format) {
    const auto* found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                     [&](const Format& candidate) { return candidate.format == format; });
    return found == std::end(kFormats) ? nullptr : found;
}

/// Optimally tiled images may share no page of this size with buffers. [Vulkan 1.3, bufferImageGranularity]
uint64_t page_bytes(const Device& device) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device.physical(), &properties);
    return properties.limits.bufferImageGranularity;
}

VkBufferImageCopy all_of(const Image& image, const Buffer& buffer, uint64_t offset) {
    if (offset > buffer.bytes() || image.packed_bytes() > buffer.bytes() - offset)
        throw Error(ErrorCode::Internal, image.structure() + " has " + std::to_string(image.packed_bytes()) +
                                             " bytes, more than " + buffer.structure() + " has from byte " +
                                             std::to_string(offset));
    VkBufferImageCopy region{};
    region.bufferOffset = offset;
    region.imageSubresource = {image.aspect(), 0, 0, image.layers()};
    region.imageExtent = {image.width(), image.height(), 1};
    return region;
}

}  // namespace

std::string format_name(VkFormat format) {
    const Format* found = find_format(format);
    return found ? found->name : "VkFormat " + std::to_string(format);
}

uint32_t pixel_bytes(VkFormat format) {
    const Format* found = find_format(format);
    return found ? found->bytes : 0;
}

VkFormatFeatureFlags format_features(const Device& device, VkFormat format) {
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(device.physical(), format, &properties);
    return properties.optimalTilingFeatures;
}

Image::Image(Device& device, std::string structure, VkFormat format, uint32_t width, uint32_t height, uint32_t layers)
    : device_(device), structure_(std::move(structure)), format_(format), width_(width), height_(height) {
    const std::string size =
        std::to_string(width) + " x " + std::to_string(height) + " x " + std::to_string(layers) + " pixels";
    if (pixel_bytes(format) == 0 || width == 0 || height == 0 || layers == 0)
        throw Error(ErrorCode::Internal, structure_ + " cannot be " + size + " of " + format_name(format));
    const bool depth = aspect() == VK_IMAGE_ASPECT_DEPTH_BIT;
    const VkFormatFeatureFlags needed =
        (depth ? VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT) |
        VK_FORMAT_FEATURE_TRANSFER_SRC_BIT | VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
    if ((format_features(device, format) & needed) != needed)
        throw Error(ErrorCode::Unsupported, device.report().name + " cannot draw into images of " +
                                                format_name(format) + ", which " + structure_ + " needs");
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {width, height, 1};
    info.mipLevels = 1;
    info.arrayLayers = layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = (depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT) |
                 VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    VkImageFormatProperties most{};
    check(vkGetPhysicalDeviceImageFormatProperties(device.physical(), format, info.imageType, info.tiling, info.usage,
                                                   0, &most),
          "asking how large " + structure_ + " may be");
    if (width > most.maxExtent.width || height > most.maxExtent.height || layers > most.maxArrayLayers)
        throw Error(ErrorCode::OutOfMemory, structure_ + " needs an image of " + size + "; " + device.report().name +
                                                " takes " + std::to_string(most.maxExtent.width) + " x " +
                                                std::to_string(most.maxExtent.height) + " x " +
                                                std::to_string(most.maxArrayLayers));
    check(device.vk().vkCreateImage(device.handle(), &info, nullptr, &handle_), "making " + structure_);
    try {
        VkMemoryRequirements requirements;
        device.vk().vkGetImageMemoryRequirements(device.handle(), handle_, &requirements);
        const uint64_t page = page_bytes(device);
        requirements.alignment = std::max(requirements.alignment, page);
        requirements.size = (requirements.size + page - 1) / page * page;
        device.require(structure_, requirements.size);
        allocation_ = device.memory().allocate(requirements, MemoryKind::Device, structure_);
        check(device.vk().vkBindImageMemory(device.handle(), handle_, allocation_.block, allocation_.offset),
              "placing " + structure_);
        make_views(layers);
    } catch (...) {
        destroy();
        throw;
    }
    device.set_name(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<uint64_t>(handle_), structure_);
}

Image::~Image() { destroy(); }

void Image::make_views(uint32_t layers) {
    views_.reserve(layers);
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = handle_;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = format_;
    for (uint32_t layer = 0; layer < layers; ++layer) {
        info.subresourceRange = {aspect(), 0, 1, layer, 1};
        VkImageView view;
        check(device_.vk().vkCreateImageView(device_.handle(), &info, nullptr, &view), "viewing " + structure_);
        views_.push_back(view);
    }
}

void Image::destroy() noexcept {
    for (const VkImageView view : views_) device_.vk().vkDestroyImageView(device_.handle(), view, nullptr);
    device_.vk().vkDestroyImage(device_.handle(), handle_, nullptr);
    if (allocation_.block) device_.memory().free(allocation_, structure_);
}

VkImageAspectFlags Image::aspect() const {
    return format_ == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

uint64_t Image::packed_bytes() const { return uint64_t{pixel_bytes(format_)} * width_ * height_ * layers(); }

void copy(CommandList& commands, Image& from, Buffer& to, uint64_t offset) {
    const VkBufferImageCopy region = all_of(from, to, offset);
    if (from.state().layout == VK_IMAGE_LAYOUT_UNDEFINED)
        throw Error(ErrorCode::Internal, from.structure() + " holds nothing to be copied");
    commands.use(from, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                 VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    commands.use(to, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    commands.flush_barrier();
    commands.device().vk().vkCmdCopyImageToBuffer(commands.handle(), from.handle(),
                                                  VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.handle(), 1, &region);
}

void copy(CommandList& commands, Buffer& from, Image& to, uint64_t offset) {
    const VkBufferImageCopy region = all_of(to, from, offset);
    commands.use(from, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
    commands.use(to, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, true);
    commands.flush_barrier();
    commands.device().vk().vkCmdCopyBufferToImage(commands.handle(), from.handle(), to.handle(),
                                                  VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
}

}  // namespace photond::gpu

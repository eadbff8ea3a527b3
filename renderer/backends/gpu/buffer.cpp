#include "renderer/backends/gpu/buffer.h"

#include <cstring>

#include "renderer/backends/gpu/command_list.h"

namespace photond::gpu {

Buffer::Buffer(Device& device, std::string structure, uint64_t bytes, MemoryKind kind)
    : device_(&device), structure_(std::move(structure)), bytes_(bytes) {
    if (bytes == 0) return;
    if (bytes > device.limits().storage_buffer_range && kind == MemoryKind::Device)
        throw Error(ErrorCode::OutOfMemory, structure_ + " needs a buffer of " + std::to_string(bytes) +
                                                " bytes; shaders of " + device.report().name + " can see " +
                                                std::to_string(device.limits().storage_buffer_range) +
                                                " bytes of one buffer");
    device.require(structure_, bytes);
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    check(device.vk().vkCreateBuffer(device.handle(), &info, nullptr, &handle_), "making " + structure_);
    try {
        VkMemoryRequirements requirements;
        device.vk().vkGetBufferMemoryRequirements(device.handle(), handle_, &requirements);
        allocation_ = device.memory().allocate(requirements, kind, structure_);
        check(device.vk().vkBindBufferMemory(device.handle(), handle_, allocation_.block, allocation_.offset),
              "placing " + structure_);
    } catch (...) {
        if (allocation_.block) device.memory().free(allocation_, structure_);
        device.vk().vkDestroyBuffer(device.handle(), handle_, nullptr);
        throw;
    }
    device.set_name(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<uint64_t>(handle_), structure_);
}

Buffer::~Buffer() {
    if (!handle_) return;
    device_->vk().vkDestroyBuffer(device_->handle(), handle_, nullptr);
    device_->memory().free(allocation_, structure_);
}

void Buffer::swap(Buffer& other) noexcept {
    std::swap(device_, other.device_), std::swap(structure_, other.structure_), std::swap(bytes_, other.bytes_);
    std::swap(handle_, other.handle_), std::swap(allocation_, other.allocation_), std::swap(state_, other.state_);
}

namespace {

constexpr uint64_t kStagingBytes = 16ull << 20;

void check_size(const Buffer& buffer, size_t bytes) {
    if (bytes > buffer.bytes())
        throw Error(ErrorCode::Internal, buffer.structure() + " has " + std::to_string(buffer.bytes()) +
                                             " bytes; to be copied were " + std::to_string(bytes));
}

}  // namespace

void upload(Device& device, Buffer& to, std::span<const std::byte> bytes, uint64_t offset) {
    check_size(to, offset + bytes.size());
    if (bytes.empty()) return;
    if (to.mapped()) {
        device.wait_idle();  // commands under way may still read what is there
        std::memcpy(to.mapped() + offset, bytes.data(), bytes.size());
        return;
    }
    Buffer staging(device, "staging", std::min<uint64_t>(bytes.size(), kStagingBytes), MemoryKind::Upload);
    for (uint64_t done = 0; done < bytes.size(); done += staging.bytes()) {
        const uint64_t now = std::min<uint64_t>(staging.bytes(), bytes.size() - done);
        std::memcpy(staging.mapped(), bytes.data() + done, now);
        CommandList commands(device);
        commands.copy(staging, 0, to, offset + done, now);
        commands.submit();
        commands.wait();
    }
}

void download(Device& device, Buffer& from, std::span<std::byte> bytes) {
    check_size(from, bytes.size());
    if (bytes.empty()) return;
    if (from.mapped()) {
        CommandList commands(device);
        commands.host_reads(from);
        commands.submit();
        commands.wait();
        std::memcpy(bytes.data(), from.mapped(), bytes.size());
        return;
    }
    Buffer staging(device, "staging", std::min<uint64_t>(bytes.size(), kStagingBytes), MemoryKind::Readback);
    for (uint64_t done = 0; done < bytes.size(); done += staging.bytes()) {
        const uint64_t now = std::min<uint64_t>(staging.bytes(), bytes.size() - done);
        CommandList commands(device);
        commands.copy(from, done, staging, 0, now);
        commands.host_reads(staging);
        commands.submit();
        commands.wait();
        std::memcpy(bytes.data() + done, staging.mapped(), now);
    }
}

}  // namespace photond::gpu

#pragma once
// A buffer on the device, which knows how it was used last, so that barriers follow by themselves (command_list.h).

#include <span>

#include "renderer/backends/gpu/device.h"

namespace photond::gpu {

/// How the commands recorded so far have used a buffer; the queue runs them in order, whatever list they are in.
struct UseState {
    VkPipelineStageFlags2 write_stages = 0, read_stages = 0;  // since the last barrier that a use waited for
    VkAccessFlags2 write_access = 0;
};

class Buffer {
public:
    Buffer() = default;  // holds nothing
    /// `structure`: its name in the accounts and in validation messages. 0 bytes: nothing is held, nothing may be
    /// bound. Throws ErrorCode::OutOfMemory past the device's limit, and with the figure past the largest storage
    /// buffer the device's shaders can see.
    Buffer(Device& device, std::string structure, uint64_t bytes, MemoryKind kind = MemoryKind::Device);
    ~Buffer();
    Buffer(Buffer&& other) noexcept { swap(other); }
    Buffer& operator=(Buffer&& other) noexcept {
        Buffer(std::move(other)).swap(*this);
        return *this;
    }

    VkBuffer handle() const { return handle_; }
    const std::string& structure() const { return structure_; }
    uint64_t bytes() const { return bytes_; }
    uint64_t memory_bytes() const { return allocation_.bytes; }  // what Memory accounts for it: rounded up
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }
    /// The host's view; null where it has none. What the device wrote is there once CommandList has been waited for,
    /// and had host_reads() said of it.
    std::byte* mapped() const { return allocation_.mapped; }
    template <class T>
    std::span<T> as() const {
        return {reinterpret_cast<T*>(mapped()), bytes_ / sizeof(T)};
    }

    UseState& state() { return state_; }

private:
    void swap(Buffer& other) noexcept;

    Device* device_ = nullptr;
    std::string structure_;
    uint64_t bytes_ = 0;
    VkBuffer handle_ = VK_NULL_HANDLE;
    Allocation allocation_;
    UseState state_;
};

/// Copies to a device buffer, from that byte of it on, and waits. `bytes` may be fewer than the buffer has.
void upload(Device& device, Buffer& to, std::span<const std::byte> bytes, uint64_t offset = 0);
/// Waits and copies from a device buffer's start.
void download(Device& device, Buffer& from, std::span<std::byte> bytes);

template <class T>
Buffer make_buffer(Device& device, std::string structure, std::span<const T> elements) {
    Buffer buffer(device, std::move(structure), std::max<uint64_t>(elements.size_bytes(), 4));
    upload(device, buffer, std::as_bytes(elements));
    return buffer;
}
template <class T>
std::vector<T> read_back(Device& device, Buffer& from, size_t count) {
    std::vector<T> elements(count);
    download(device, from, std::as_writable_bytes(std::span(elements)));
    return elements;
}

}  // namespace photond::gpu

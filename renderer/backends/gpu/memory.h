#pragma once
// Device memory: blocks that buffers and images are placed in, with exact bytes by structure and a limit.

#include <list>
#include <memory>
#include <mutex>
#include <vector>

#include "renderer/backends/gpu/vulkan.h"
#include "renderer/core/memory_budget.h"

namespace photond::gpu {

enum class MemoryKind : uint8_t {
    Device,    // fastest for the device; mapped where the host can see it (software devices)
    Upload,    // the host writes, the device reads
    Readback,  // the device writes, the host reads: cached
};

/// A piece of a block. Owned by who asked for it and given back to the same Memory.
struct Allocation {
    VkDeviceMemory block = VK_NULL_HANDLE;
    uint64_t offset = 0;
    uint64_t bytes = 0;
    std::byte* mapped = nullptr;  // null: the host cannot see it
    uint32_t pool = 0;            // Memory's own
};

/// Places what it is asked for in blocks, first fit; what is larger than half a block gets one of its own. Thread-safe.
class Memory {
public:
    Memory(VkPhysicalDevice physical, VkDevice device, const VolkDeviceTable& vk, bool software);
    ~Memory();
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    /// Throws ErrorCode::OutOfMemory, naming the structure with its bytes, when the device has no more.
    Allocation allocate(const VkMemoryRequirements& requirements, MemoryKind kind, const std::string& structure);
    void free(const Allocation& allocation, const std::string& structure);

    /// Bytes asked for, by structure, of all that lives now.
    std::map<std::string, uint64_t> structures() const;
    uint64_t used_bytes() const;   // their sum
    uint64_t peak_bytes() const;   // the greatest it has been since reset_peak()
    uint64_t block_bytes() const;  // what the driver was asked for
    void reset_peak();

private:
    struct Block {
        VkDeviceMemory memory;
        uint64_t bytes;
        std::byte* mapped;
        std::map<uint64_t, uint64_t> free;  // offset -> bytes, never adjacent
    };
    struct Pool {
        uint32_t memory_type;
        std::list<Block> blocks;
    };
    uint32_t pool_for(uint32_t allowed_types, MemoryKind kind);
    Block make_block(const Pool& pool, uint64_t bytes, const std::string& structure);

    const VkDevice device_;
    const VolkDeviceTable& vk_;
    const uint64_t block_size_;
    VkPhysicalDeviceMemoryProperties properties_{};
    mutable std::mutex mutex_;
    std::vector<Pool> pools_;
    std::map<std::string, uint64_t> structures_;
    uint64_t used_bytes_ = 0, peak_bytes_ = 0, block_bytes_ = 0;
};

}  // namespace photond::gpu

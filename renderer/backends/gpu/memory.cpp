#include "renderer/backends/gpu/memory.h"

#include <algorithm>

namespace photond::gpu {

namespace {

/// Small enough that tests with little in them take little; a card's many gigabytes ask for fewer, larger ones.
constexpr uint64_t kBlockBytes = 64ull << 20, kSoftwareBlockBytes = 8ull << 20;

constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

uint64_t align_up(uint64_t x, uint64_t alignment) { return (x + alignment - 1) / alignment * alignment; }

}  // namespace

Memory::Memory(VkPhysicalDevice physical, VkDevice device, const VolkDeviceTable& vk, bool software)
    : device_(device), vk_(vk), block_size_(software ? kSoftwareBlockBytes : kBlockBytes) {
    vkGetPhysicalDeviceMemoryProperties(physical, &properties_);
}

Memory::~Memory() {
    for (const Pool& pool : pools_)
        for (const Block& block : pool.blocks) vk_.vkFreeMemory(device_, block.memory, nullptr);
}

/// The pool of the best type that is allowed: all flags that are wanted, else those that are needed.
uint32_t Memory::pool_for(uint32_t allowed_types, MemoryKind kind) {
    const VkMemoryPropertyFlags needed = kind == MemoryKind::Device ? VkMemoryPropertyFlags{0} : kHost;
    VkMemoryPropertyFlags wanted = needed;
    if (kind == MemoryKind::Device) wanted |= VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    if (kind == MemoryKind::Readback) wanted |= VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    for (const VkMemoryPropertyFlags flags : {wanted, needed}) {
        for (uint32_t type = 0; type < properties_.memoryTypeCount; ++type) {
            if (!(allowed_types >> type & 1u) || (properties_.memoryTypes[type].propertyFlags & flags) != flags)
                continue;
            for (uint32_t i = 0; i < pools_.size(); ++i)
                if (pools_[i].memory_type == type) return i;
            pools_.push_back({type, {}});
            return static_cast<uint32_t>(pools_.size()) - 1;
        }
    }
    throw Error(ErrorCode::Unsupported, "the GPU has no memory of the kind that is needed");
}

Memory::Block Memory::make_block(const Pool& pool, uint64_t bytes, const std::string& structure) {
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = bytes;
    info.memoryTypeIndex = pool.memory_type;
    Block block{VK_NULL_HANDLE, bytes, nullptr, {{0, bytes}}};
    check(vk_.vkAllocateMemory(device_, &info, nullptr, &block.memory),
          "allocating " + std::to_string(bytes) + " bytes for " + structure + " beside " +
              std::to_string(block_bytes_) + " bytes held");
    // What is not coherent would need flushes: the host does not look at it.
    if ((properties_.memoryTypes[pool.memory_type].propertyFlags & kHost) == kHost) {
        void* mapped = nullptr;
        const VkResult result = vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &mapped);
        if (result != VK_SUCCESS) vk_.vkFreeMemory(device_, block.memory, nullptr);
        check(result, "mapping memory for " + structure);
        block.mapped = static_cast<std::byte*>(mapped);
    }
    block_bytes_ += bytes;
    return block;
}

Allocation Memory::allocate(const VkMemoryRequirements& requirements, MemoryKind kind, const std::string& structure) {
    const std::scoped_lock lock(mutex_);
    const uint32_t index = pool_for(requirements.memoryTypeBits, kind);
    Pool& pool = pools_[index];
    const uint64_t bytes = requirements.size, alignment = std::max<uint64_t>(requirements.alignment, 256);
    const auto place = [&](Block& block) {
        Allocation found;
        for (const auto& [offset, size] : block.free) {
            const uint64_t start = align_up(offset, alignment), end = offset + size;
            if (start + bytes > end) continue;
            found = {block.memory, start, bytes, block.mapped ? block.mapped + start : nullptr, index};
            const uint64_t first = offset;
            block.free.erase(offset);
            if (start > first) block.free[first] = start - first;
            if (end > start + bytes) block.free[start + bytes] = end - start - bytes;
            break;
        }
        return found;
    };
    Allocation allocation;
    if (bytes <= block_size_ / 2)
        for (Block& block : pool.blocks) {
            allocation = place(block);
            if (allocation.block) break;
        }
    if (!allocation.block) {
        pool.blocks.push_back(make_block(pool, bytes <= block_size_ / 2 ? block_size_ : bytes, structure));
        allocation = place(pool.blocks.back());
    }
    structures_[structure] += bytes;
    used_bytes_ += bytes;
    peak_bytes_ = std::max(peak_bytes_, used_bytes_);
    return allocation;
}

void Memory::free(const Allocation& allocation, const std::string& structure) {
    const std::scoped_lock lock(mutex_);
    used_bytes_ -= allocation.bytes;
    if ((structures_[structure] -= allocation.bytes) == 0) structures_.erase(structure);
    std::list<Block>& blocks = pools_[allocation.pool].blocks;
    const auto block =
        std::find_if(blocks.begin(), blocks.end(), [&](const Block& b) { return b.memory == allocation.block; });
    uint64_t first = allocation.offset, end = first + allocation.bytes;
    const auto after = block->free.lower_bound(first);
    if (after != block->free.end() && after->first == end) {
        end += after->second;
        block->free.erase(after);
    }
    const auto next = block->free.lower_bound(first);
    if (next != block->free.begin()) {
        const auto before = std::prev(next);
        if (before->first + before->second == first) {
            first = before->first;
            block->free.erase(before);
        }
    }
    block->free[first] = end - first;
    // A block that holds nothing goes back to the driver: a worker keeps the device for days.
    if (end - first == block->bytes) {
        block_bytes_ -= block->bytes;
        vk_.vkFreeMemory(device_, block->memory, nullptr);
        blocks.erase(block);
    }
}

std::map<std::string, uint64_t> Memory::structures() const {
    const std::scoped_lock lock(mutex_);
    return structures_;
}

uint64_t Memory::used_bytes() const {
    const std::scoped_lock lock(mutex_);
    return used_bytes_;
}

uint64_t Memory::peak_bytes() const {
    const std::scoped_lock lock(mutex_);
    return peak_bytes_;
}

uint64_t Memory::block_bytes() const {
    const std::scoped_lock lock(mutex_);
    return block_bytes_;
}

void Memory::reset_peak() {
    const std::scoped_lock lock(mutex_);
    peak_bytes_ = used_bytes_;
}

}  // namespace photond::gpu

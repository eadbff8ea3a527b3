#include "renderer/core/memory_budget.h"

#include "protocol/error.h"

namespace photond {

void MemoryBudget::require(const std::string& structure, uint64_t bytes) const {
    const uint64_t held = accounted_bytes();
    if (bytes <= limit_bytes_ && held <= limit_bytes_ - bytes) return;
    throw Error(ErrorCode::OutOfMemory, structure + " needs " + std::to_string(bytes) + " bytes beside the " +
                                            std::to_string(held) + " in use; the limit is " +
                                            std::to_string(limit_bytes_) + " bytes");
}

void MemoryBudget::record(const std::string& structure, uint64_t bytes) { structures_[structure] = bytes; }

uint64_t MemoryBudget::accounted_bytes() const {
    uint64_t sum = 0;
    for (const auto& [name, bytes] : structures_) sum += bytes;
    return sum;
}

}  // namespace photond

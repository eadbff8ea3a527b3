#pragma once
// What a job may allocate, and what each of its structures took.

#include <cstdint>
#include <map>
#include <string>

namespace photond {

/// Exact bytes by structure, and the limit they must stay under. Not thread-safe: structures are built one at a time.
class MemoryBudget {
public:
    explicit MemoryBudget(uint64_t limit_bytes = UINT64_MAX) : limit_bytes_(limit_bytes) {}

    /// Throws ErrorCode::OutOfMemory, with the estimate and the limit, when `bytes` more would pass the limit; call it
    /// before allocating.
    void require(const std::string& structure, uint64_t bytes) const;
    /// Records the bytes a structure holds now (replacing what it was said to hold before).
    void record(const std::string& structure, uint64_t bytes);

    uint64_t limit_bytes() const { return limit_bytes_; }
    uint64_t accounted_bytes() const;
    const std::map<std::string, uint64_t>& structures() const { return structures_; }

private:
    uint64_t limit_bytes_;
    std::map<std::string, uint64_t> structures_;
};

}  // namespace photond

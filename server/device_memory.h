#pragma once
// How much of a GPU's memory photond uses: the daemon refuses by it, the worker keeps to it.

#include <algorithm>
#include <cstdint>

namespace photond {

/// Of all jobs and scenes together. A software device's memory is the host's, which has a limit of its own.
inline uint64_t device_limit_bytes(uint64_t memory_bytes, bool software, uint64_t host_limit_bytes) {
    return software ? std::min(memory_bytes, host_limit_bytes) : memory_bytes;
}

/// Share of that which scenes of other jobs may keep while they are not used.
inline constexpr uint64_t kIdleDeviceScenesDivisor = 8;

/// What is left for one job.
inline uint64_t job_device_limit_bytes(uint64_t device_limit) {
    return device_limit - device_limit / kIdleDeviceScenesDivisor;
}

}  // namespace photond

#include "server/workers/address_space.h"

#include <sys/resource.h>

#include <algorithm>

#include "protocol/error.h"

namespace photond {

namespace {

constexpr uint64_t kLibraries = 256ull << 20;    // a worker's own and those it loads for images: 225 MB
constexpr uint64_t kLeastOfJobs = 256ull << 20;  // where nobody said less

uint64_t kib(uint64_t bytes) { return (bytes + 1023) / 1024; }

}  // namespace

uint64_t granted_address_space() {
    rlimit limit{};
    return getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ? UINT64_MAX : limit.rlim_cur;
}

uint64_t memory_limit_within(uint64_t granted_bytes, uint64_t asked_bytes, uint64_t machine_bytes, unsigned threads) {
    const uint64_t beside = kLibraries + worker_address_space(0, threads);
    const uint64_t left = granted_bytes - std::min(granted_bytes, beside);
    const uint64_t least = asked_bytes ? asked_bytes : kLeastOfJobs;
    if (left < least)
        throw Error(ErrorCode::OutOfMemory,
                    "a process is granted " + std::to_string(granted_bytes / 1024) +
                        " KiB of address space (ulimit -v); photond needs " + std::to_string(kib(beside + least)) +
                        ": " + std::to_string(kib(beside)) + " for a worker of " + std::to_string(threads) +
                        " threads and " + std::to_string(kib(least)) + " for what its jobs hold (--memory-limit)");
    return asked_bytes ? asked_bytes : std::min(machine_bytes / 4 * 3, left);
}

}  // namespace photond

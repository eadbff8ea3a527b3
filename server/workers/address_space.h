#pragma once
// Address space: what a process maps beside what its jobs hold, and what jobs may hold where it is bounded (ulimit -v).

#include <cstdint>

namespace photond {

/// What a worker or a helper may map beyond its libraries, so that its jobs may hold so much: thread stacks and the
/// arenas of malloc and TBB reserve more than they use. Measured at the peak of a Sponza render: 0.75 GB more than is
/// resident with 2 threads, 1.43 GB with 16.
constexpr uint64_t worker_address_space(uint64_t memory_limit_bytes, unsigned threads) {
    return memory_limit_bytes + (1ull << 30) + threads * (64ull << 20);
}

/// What the system grants each process; UINT64_MAX: no bound.
uint64_t granted_address_space();

/// What jobs may hold in a worker: what was asked for, or where that is 0, three quarters of the machine's memory, but
/// no more than the address space that is granted leaves to it. Throws photond::Error (OutOfMemory), which says what is
/// needed, where jobs would have less than was asked for, or next to nothing.
uint64_t memory_limit_within(uint64_t granted_bytes, uint64_t asked_bytes, uint64_t machine_bytes, unsigned threads);

}  // namespace photond

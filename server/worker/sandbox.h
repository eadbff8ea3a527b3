#pragma once
// What a worker gives up before it reads the first byte that a stranger wrote.

#include <cstdint>

namespace photond {

struct SandboxLimits {
    uint64_t memory_bytes = 0;  // what jobs may hold; address space is bounded somewhat above it
    uint64_t file_bytes = 0;    // largest file that may be written
    unsigned threads = 1;
};

/// Binds the process' life to its parent's (SIGKILL when the thread that started it ends; `parent_socket` tells a
/// parent that was gone before), takes away core dumps and new privileges, bounds files and address space, and forbids,
/// by seccomp for all threads, what a renderer has no use for: new sockets, other programs, other processes, other
/// users' rights, the kernel's configuration. A forbidden call fails with EPERM. SIGTERM, SIGINT, SIGPIPE and SIGXFSZ
/// are ignored: the daemon speaks through the socket. Call it before any thread is started. Throws photond::Error
/// (Internal) when any of it does not hold, ErrorCode::WorkerLost when the parent is gone.
void enter_sandbox(const SandboxLimits& limits, int parent_socket);

}  // namespace photond

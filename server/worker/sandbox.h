#pragma once
// What a worker gives up before it reads the first byte that a stranger wrote.

#include <cstdint>

namespace photond {

struct SandboxLimits {
    uint64_t memory_bytes = 0;  // what jobs may hold; address space is bounded somewhat above it
    uint64_t file_bytes = 0;    // largest file that may be written
    unsigned threads = 1;
    /// A GPU's driver maps more than a job will ever hold: the daemon watches what is resident instead.
    bool bound_address_space = true;
    /// It is to become another program, one that may be executed (file_access.h); that is held to the same.
    bool becomes_program = false;
};

/// Binds the process' life to its parent's (SIGKILL when the thread that started it ends; `parent_socket` tells a
/// parent that was gone before), takes away core dumps, lets no other process of its user look into it (it is not
/// dumpable), and puts it first in line when memory runs out. SIGTERM, SIGINT, SIGPIPE and SIGXFSZ are ignored: the
/// daemon speaks through the socket. Throws photond::Error (Internal) when any of it does not hold,
/// ErrorCode::WorkerLost when the parent is gone.
void bind_to_parent(int parent_socket);

/// Takes away what only root may do, but for reading and writing files of any user, in this thread and those it starts.
/// Throws photond::Error (Internal).
void give_up_capabilities();

/// Takes away new privileges, bounds the size of files and the address space, and forbids, by seccomp for all threads,
/// those that are there already among them, what a renderer has no use for: new sockets, other programs
/// (but as `limits` says), other processes, other users' rights, owners, modes and times of files, the kernel's
/// configuration. A forbidden call fails with EPERM. Which files are opened is bounded before (file_access.h). A GPU is
/// opened in between: its driver may ask services of the machine to get at the device, and no stranger has said
/// anything by then. Throws photond::Error (Internal) when any of it does not hold.
void enter_sandbox(const SandboxLimits& limits);

}  // namespace photond

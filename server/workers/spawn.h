#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace photond {

struct Child {
    pid_t pid = -1;
    int socket = -1;  // our end, close-on-exec; the child has its own as file descriptor 3
};

/// How much of the processors a child is given beside others.
struct Priority {
    int nice = 0;             // added to the daemon's own
    bool background = false;  // the lowest scheduling class (SCHED_IDLE): what nobody else wants
};

/// Starts a program with nothing of ours but standard error and one end of a socket pair: no other file descriptor, no
/// blocked signal, a process group of its own, its priority, core dumps off, and SIGKILL when the calling
/// thread ends. Throws photond::Error (Internal) when the system refuses.
Child spawn_child(const std::filesystem::path& program, const std::vector<std::string>& arguments, Priority priority);

}  // namespace photond

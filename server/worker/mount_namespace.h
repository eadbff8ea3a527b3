#pragma once
// A file system of a process's own, which has only what rules name: for kernels without Landlock.

#include <string>
#include <vector>

#include "server/worker/file_rules.h"

namespace photond {

/// Moves this process, which must have one thread, into a user and a mount namespace of its own whose root holds what
/// the rules allow at the paths that it has outside; what is only to be read is mounted read-only. The process has no
/// rights over others outside: it cannot look into one that is not dumpable. It is tried in a child first: where the
/// system has no namespaces for us, the reason is returned and nothing is changed. Throws photond::Error (Internal)
/// when it fails after that.
std::string enter_mount_namespace(const std::vector<FileRule>& rules);

}  // namespace photond

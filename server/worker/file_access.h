#pragma once
// What bounds the files that this process opens, the best that its kernel has.

#include <vector>

#include "protocol/message_parts.h"
#include "server/worker/file_rules.h"

namespace photond {

/// Bounds them to what the rules allow: by Landlock, else by a mount namespace, else by nothing, which is logged with
/// the reason. To be called while the process has one thread. Throws photond::Error (Internal) when what is there does
/// not hold.
FileAccess bound_file_access(const std::vector<FileRule>& rules);

}  // namespace photond

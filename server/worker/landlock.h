#pragma once
// Landlock: the kernel's own bounds on the files a process opens, which it sets itself and cannot take back
// (landlock(7)).

#include <vector>

#include "server/worker/file_rules.h"

namespace photond {

/// The version that this kernel has; 0: none. PHOTOND_LANDLOCK_VERSION in the environment has it taken for an older
/// one.
int landlock_version();

/// From here on the calling thread, and those it starts, open only what resolved() rules allow, and reach no other
/// process: no debugging (every version), no signals (from the sixth). Before the third version a file may still be
/// cut off by who may not write it: forbid truncate() and O_TRUNC without writing by other means. Takes new privileges
/// away too. Throws photond::Error (Internal) when it does not hold.
void enter_landlock(int version, const std::vector<FileRule>& rules);

}  // namespace photond

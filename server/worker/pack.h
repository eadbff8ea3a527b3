#pragma once
#include "protocol/helper_messages.h"

namespace photond {

/// Throws ErrorCode::NoSpace or ErrorCode::Internal where a file cannot be read or the archive not be written.
void pack_files(const PackRequest& asked);

}  // namespace photond

#pragma once
// The helper's tasks on films of one method that differ by their seed: bias and noise apart, and where the bias is.

#include <cstdint>

#include "protocol/helper_messages.h"

namespace photond {

/// Reads one layer of all films at a time. Throws ErrorCode::OutOfMemory where that is more than `memory_bytes`,
/// ErrorCode::Conflict at /films where sizes differ or the reference is not two films, and what loading films throws.
MeasureSeedsReply measure_seeds(const MeasureSeedsRequest& asked, uint64_t memory_bytes);

/// Each block's colour is its difference, found ones framed (renderer/error/welch_picture.h). Throws
/// ErrorCode::WrongType where the map is none.
void encode_bias_map(const EncodeBiasMapRequest& asked);

}  // namespace photond

#pragma once
// The helper's task on frames of a sequence: how wrong one is, and how wrong what has changed since the one before.

#include <cstdint>

#include "protocol/helper_messages.h"

namespace photond {

/// Throws ErrorCode::OutOfMemory where the layer of all films is more than `memory_bytes`, ErrorCode::Conflict where
/// their sizes differ, ErrorCode::UnknownName at /layer, and what loading films throws.
MeasureFrameReply measure_frame(const MeasureFrameRequest& asked, uint64_t memory_bytes);

}  // namespace photond

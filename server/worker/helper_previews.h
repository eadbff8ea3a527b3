#pragma once
// The helper's tasks on films as pictures for people.

#include <cstdint>

#include "protocol/helper_messages.h"

namespace photond {

/// Both throw ErrorCode::OutOfMemory, ErrorCode::UnknownName at /curve, and what loading films and writing a PNG throw.
/// ErrorCode::UnknownName at /layer for one that the film does not have, or that has no preview.
void encode_preview(const EncodePreviewRequest& asked, uint64_t memory_bytes);
/// ErrorCode::Conflict where the films differ in size.
void encode_sheet(const EncodeSheetRequest& asked, uint64_t memory_bytes);

}  // namespace photond

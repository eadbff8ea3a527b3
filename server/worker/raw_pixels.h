#pragma once
// Pixels as viewers take them: little-endian, interleaved, row 0 at the top, without a header.

#include <filesystem>
#include <span>
#include <string>

#include "protocol/helper_messages.h"
#include "renderer/core/geometry.h"
#include "renderer/film/exr_file.h"

namespace photond {

/// "float" or "half", as requests of the helper name it; throws ErrorCode::UnknownName for anything else.
Precision precision_named(const std::string& name);

/// Writes them; the reply has all but the mean.
EncodedReply write_raw_pixels(Size2 size, uint32_t channels, std::span<const float> pixels, Precision precision,
                              const std::filesystem::path& path);

/// One layer of a film or of an image file. `memory_bytes` bounds what is held. Throws ErrorCode::UnknownName at /layer
/// where there is no such layer.
EncodedReply encode_pixels(const EncodePixelsRequest& asked, uint64_t memory_bytes);

}  // namespace photond

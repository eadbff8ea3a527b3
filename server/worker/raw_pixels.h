#pragma once
// Pixels as viewers take them: little-endian, interleaved, row 0 at the top, without a header.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "renderer/core/geometry.h"
#include "renderer/film/exr_file.h"

namespace photond {

/// "precision" of a helper's request. Throws ErrorCode::UnknownName.
Precision precision_of(const nlohmann::json& message);

/// Writes them and returns {"width", "height", "channels", "overflowed"}: the last one says how many finite values half
/// precision has made infinite.
nlohmann::json write_raw_pixels(Size2 size, uint32_t channels, std::span<const float> pixels, Precision precision,
                                const std::filesystem::path& path);

/// The helper's task encode_pixels (worker_messages.h): one layer of a film or of an image file. `memory_bytes` bounds
/// what is held. Throws ErrorCode::UnknownName at /layer where there is no such layer.
nlohmann::json encode_pixels(const nlohmann::json& message, uint64_t memory_bytes);

}  // namespace photond

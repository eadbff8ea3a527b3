#pragma once
#include <cstdint>
#include <filesystem>
#include <span>

#include "renderer/core/geometry.h"

namespace photond {

/// Writes interleaved 8-bit sRGB as a PNG, row 0 at the top, without a date: the same pixels give the same bytes.
/// Throws ErrorCode::NoSpace when the disk is full.
void write_png(Size2 size, std::span<const uint8_t> rgb, const std::filesystem::path& path);

}  // namespace photond

#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// Interleaved 8-bit sRGB as a PNG, row 0 at the top, without a date: the same pixels give the same bytes.
/// `compression` 0 to 9: noisy pictures are hardly smaller by 6 than by 1, and take several times as long.
std::vector<uint8_t> encode_png(Size2 size, std::span<const uint8_t> rgb, int compression = 2);

/// The same, written to a file. Throws ErrorCode::NoSpace when the disk is full.
void write_png(Size2 size, std::span<const uint8_t> rgb, const std::filesystem::path& path);

}  // namespace photond

#pragma once
// What an image file says of itself, judged within bounds before an image library sees the file: a library takes a
// header's word for how many attributes, parts, channels and offsets there are, and time or memory for each.
//
// OpenEXR by "OpenEXR File Layout" (openexr.com), Radiance HDR by [Ward 1991] Real Pixels, Graphics Gems II.

#include <cstdint>
#include <filesystem>

namespace photond {

/// Limits on images that come from outside.
inline constexpr uint64_t kMaxImagePixels = 64ull << 20;
inline constexpr uint32_t kMaxImageChannels = 128;
inline constexpr uint64_t kMaxImageValues = 512ull << 20;  // pixels x channels: 2 GiB as float
/// The library takes quadratic time in their number: a thousand take it 30 ms, a hundred thousand two minutes.
inline constexpr uint32_t kMaxHeaderAttributes = 1000;
inline constexpr uint64_t kMaxHeaderBytes = 16ull << 20;
inline constexpr uint64_t kMaxRadianceHeaderBytes = 64ull << 10;

enum class ImageFileFormat : uint8_t { OpenExr, Radiance };

/// By the file's first bytes; names are not looked at. Throws ErrorCode::BadImage, with the fault and its place in the
/// file, where the file is neither format, no regular file, or its header passes a bound above or contradicts itself:
/// ends early, names sizes beyond the file, has several parts, deep data, or an offset of pixels that is not in the
/// file. What passes may still be refused by the library. Reads no pixels; takes time in proportion to the header and
/// the table of offsets.
ImageFileFormat judge_image_file_header(const std::filesystem::path& path);

/// Throws ErrorCode::BadImage for no pixels at all, or more of anything than the limits above.
void require_image_size(uint64_t width, uint64_t height, uint64_t channels);

}  // namespace photond

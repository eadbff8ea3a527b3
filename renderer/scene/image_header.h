#pragma once
// What an encoded image says of itself, read from its first bytes without decoding anything: whether it is one of the
// formats accepted here, and how large it would become.

#include <cstdint>
#include <span>

#include "renderer/core/geometry.h"

namespace photond {

enum class ImageFormat : uint8_t { Png, Jpeg, OpenExr, RadianceHdr };

struct ImageHeader {
    ImageFormat format = ImageFormat::Png;
    Size2 size;
};

/// Reads the header of a PNG, JPEG, OpenEXR or Radiance HDR image, told apart by its first bytes. Throws
/// ErrorCode::BadImage for anything else, for a malformed header, for a PNG or JPEG cut short, and for a size of 0.
ImageHeader read_image_header(std::span<const uint8_t> encoded);

/// Throws ErrorCode::BadImage when the image has more than `max_pixels`, or when its texels of `texel_bytes` would take
/// more than 10,000 times the bytes it is stored in (a decompression bomb).
void judge_image_size(const ImageHeader& header, uint64_t encoded_bytes, uint64_t texel_bytes, uint64_t max_pixels);

}  // namespace photond

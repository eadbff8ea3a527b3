#pragma once
// The helper's tasks on two images: measuring one against the other, and pictures of where they differ.
//
// All throw ErrorCode::Conflict at /image when the sizes differ, and the fault of a file that cannot be read at the
// field that names it; ErrorCode::UnknownName for what is no metric or no layer of both, saying what there is.

#include <cstdint>

#include "protocol/helper_messages.h"

namespace photond {

/// Metrics are named alone or as LAYER:name. A value that its definition does not give is null, and a note says why.
/// `memory_bytes` bounds the pixels held.
MeasureReply measure_images(const MeasureRequest& asked, uint64_t memory_bytes);

/// EXR of x - r: the beauty and every layer of radiance that both hold.
void encode_difference(const EncodeDifferenceRequest& asked, uint64_t memory_bytes);

/// PNG of the FLIP map of a layer.
EncodedReply encode_flip(const EncodeFlipRequest& asked, uint64_t memory_bytes);
/// The same map as raw pixels of one channel, 0 to 1.
EncodedReply encode_flip_map(const EncodeFlipMapRequest& asked, uint64_t memory_bytes);

/// PNG of each pixel's relative error (conventions.md, "Error") on a fixed logarithmic scale; grey where it is not
/// defined.
void encode_error_map(const EncodeErrorMapRequest& asked, uint64_t memory_bytes);

/// Ends of the error map's scale: the darkest and the brightest colour.
inline constexpr double kLeastMappedError = 1e-3, kGreatestMappedError = 10;

}  // namespace photond

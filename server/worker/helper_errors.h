#pragma once
// The helper's tasks on two images: measuring one against the other, and pictures of where they differ. Each takes and
// gives what worker_messages.h says, "image" and "reference" being a film or an image file.
//
// All throw ErrorCode::Conflict at /image when the sizes differ, and the fault of a file that cannot be read at the
// field that names it; ErrorCode::UnknownName for what is no metric or no layer of both, saying what there is.

#include <cstdint>
#include <nlohmann/json.hpp>

namespace photond {

/// "metrics": names, each also as LAYER:name; none: those of the beauty that cost little. A value that its definition
/// does not give is null, and a note says why. `memory_bytes` bounds the pixels held.
nlohmann::json measure_images(const nlohmann::json& message, uint64_t memory_bytes);

/// EXR of x - r: the beauty and every layer of radiance that both hold.
nlohmann::json encode_difference(const nlohmann::json& message, uint64_t memory_bytes);

/// PNG of the FLIP map of a layer.
nlohmann::json encode_flip(const nlohmann::json& message, uint64_t memory_bytes);
/// The same map as raw pixels of one channel, 0 to 1.
nlohmann::json encode_flip_map(const nlohmann::json& message, uint64_t memory_bytes);

/// PNG of each pixel's relative error (conventions.md, "percentiles") on a fixed logarithmic scale; grey where it is
/// not defined.
nlohmann::json encode_error_map(const nlohmann::json& message, uint64_t memory_bytes);

/// Ends of the error map's scale: the darkest and the brightest colour.
inline constexpr double kLeastMappedError = 1e-3, kGreatestMappedError = 10;

}  // namespace photond

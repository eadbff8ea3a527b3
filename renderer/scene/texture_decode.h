#pragma once
// Encoded images to textures and environments. The header is judged before anything is decoded; only PNG, JPEG
// (textures) and OpenEXR, Radiance HDR (environments) are accepted. The only file of scene/ that knows an image
// library.

#include <span>

#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/image_header.h"
#include "renderer/scene/texture.h"

namespace photond {

/// Decodes a PNG or JPEG to RGBA8, alpha not multiplied in, colour codes as stored; grey is spread over r, g, b, and an
/// absent alpha is 1. Can be called from several threads at once. An ImageDecoder for load_gltf(). Throws
/// ErrorCode::BadImage.
Texture decode_texture(std::span<const uint8_t> encoded, const LoadLimits& limits);

/// Decodes an OpenEXR or Radiance HDR image to an environment; channels R, G, B (or one grey channel, spread). Throws
/// ErrorCode::BadImage when it is too large, cannot be decoded, or holds a value that is negative, infinite or NaN.
EnvironmentMap decode_environment(std::span<const uint8_t> encoded, const LoadLimits& limits);

/// The header of an environment image, judged against the limits; decodes nothing. Throws as decode_environment().
ImageHeader judge_environment(std::span<const uint8_t> encoded, const LoadLimits& limits);

}  // namespace photond

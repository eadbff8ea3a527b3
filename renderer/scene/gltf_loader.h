#pragma once
// From the bytes of a glTF bundle to a Scene. Everything a file says is validated before it is used.

#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/texture.h"

namespace photond {

struct Scene;

/// Limits against files that ask for more than they are worth.
struct LoadLimits {
    uint64_t max_file_bytes = 4ull << 30;
    uint64_t max_triangles = 200'000'000;
    uint64_t max_texture_pixels = 64ull << 20;         // of one image
    uint64_t max_total_texture_pixels = 512ull << 20;  // of all images of a scene
    /// Of keys, morph targets, joints and sparse accessors together, besides as many bytes as the files have: several
    /// may be made of the same bytes, or of none.
    uint64_t max_made_bytes = 192ull << 20;
    uint32_t max_json_depth = 64;
    uint64_t max_json_values = 4'000'000;
};

/// Decodes one encoded image (PNG, JPEG) to RGBA8 after judging its header. Given to the loader from outside, so that
/// the renderer does not link an image library (texture_decode.h has OpenImageIO's). Throws ErrorCode::BadImage.
using ImageDecoder = std::function<Texture(std::span<const uint8_t> encoded, const LoadLimits& limits)>;

/// Loads a .glb or .gltf file; further files are opened below `bundle_root` only (no absolute paths, no "..", no
/// links). What is animated is posed at rest (pose.h). Throws photond::Error with JSON pointers into the glTF.
Scene load_gltf(const std::filesystem::path& file, const std::filesystem::path& bundle_root, const ImageDecoder& decode,
                const LoadLimits& limits = {});

/// Width over height of the image that each camera of such a file asks for, by the name that load_gltf() gives it, of
/// cameras that have one and ask for something. No image depends on it: a job says its own width and height.
std::map<std::string, double> gltf_camera_aspects(const std::filesystem::path& file,
                                                  const std::filesystem::path& bundle_root,
                                                  const LoadLimits& limits = {});

}  // namespace photond

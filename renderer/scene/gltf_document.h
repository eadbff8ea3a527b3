#pragma once
// A glTF 2.0 document, judged sound (gltf_judge.h) and then parsed by tinygltf, which is handed placeholders for
// buffers and images and opens no file.

// The parts of tinygltf that would read files and images are not compiled in; gltf_parser.cpp holds the rest.
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/gltf_json.h"
#include "renderer/scene/gltf_layout.h"
#include "renderer/scene/rig.h"

namespace photond {

struct GltfBuffer {
    std::optional<std::string> uri;  // absent: the binary chunk of a .glb, or a meshopt fallback
    uint64_t byte_length = 0;
    bool meshopt_fallback = false;  // EXT_meshopt_compression: holds no data
};

struct GltfDocument {
    /// Its buffers hold nothing. Its images hold nothing but what the file says of them: a view, or else a uri.
    tinygltf::Model model;
    std::vector<GltfBuffer> buffers;
    std::vector<std::string> warnings;

    /// The one to load; null where there are none.
    const tinygltf::Scene* scene() const;
};

/// tinygltf's part: of text that was judged and made plain.
tinygltf::Model parse_plain_gltf(const std::string& text);

/// Parses, judges and reads a whole document. Throws what parse_json() and judge_gltf() throw.
GltfDocument read_gltf_document(std::string_view text, const JsonBounds& bounds);

/// An attribute's accessor, or nothing.
std::optional<int> gltf_attribute(const tinygltf::Primitive& primitive, const std::string& semantic);

ElementLayout element_layout(const tinygltf::Accessor& accessor);

/// An extension of an object of the model, or null.
const tinygltf::Value* gltf_extension(const tinygltf::ExtensionMap& extensions, const std::string& name);

/// The light of KHR_lights_punctual at a node, or nothing.
std::optional<int> gltf_light(const tinygltf::Node& node);

/// The material, whose texture references still count the document's textures and texture coordinate sets. `animated`:
/// with the textures that have no effect at rest.
Material read_gltf_material(const tinygltf::Material& material, bool animated = false);
/// What an animation needs to know of it besides, for pose.h.
RiggedMaterial read_rigged_material(const tinygltf::Material& material);

}  // namespace photond

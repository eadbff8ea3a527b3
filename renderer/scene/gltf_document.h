#pragma once
// A glTF 2.0 document as typed structures. Whoever holds one may rely on it: every index is in range, every number is
// finite and within the specification's range, every byte range lies inside its buffer's stated length, the node
// hierarchy is a forest. Nothing of a buffer's or image's contents has been looked at yet.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/gltf_json.h"
#include "renderer/scene/light.h"
#include "renderer/scene/material.h"

namespace photond {

struct GltfBuffer {
    std::optional<std::string_view> uri;  // absent: the binary chunk of a .glb, or a meshopt fallback
    uint64_t byte_length = 0;
    bool meshopt_fallback = false;  // EXT_meshopt_compression: holds no data
};

struct GltfByteRange {
    uint32_t buffer = 0;
    uint64_t offset = 0;
    uint64_t length = 0;
};

/// EXT_meshopt_compression of a buffer view.
struct GltfMeshopt {
    enum class Mode : uint8_t { Attributes, Triangles, Indices };
    enum class Filter : uint8_t { None, Octahedral, Quaternion, Exponential };
    GltfByteRange source;
    uint32_t stride = 0;
    uint64_t count = 0;
    Mode mode = Mode::Attributes;
    Filter filter = Filter::None;
};

struct GltfBufferView {
    GltfByteRange bytes;
    uint32_t stride = 0;  // 0: tightly packed
    std::optional<GltfMeshopt> meshopt;
};

enum class ComponentType : uint16_t { I8 = 5120, U8 = 5121, I16 = 5122, U16 = 5123, U32 = 5125, F32 = 5126 };
constexpr uint32_t component_bytes(ComponentType type) {
    return type == ComponentType::I8 || type == ComponentType::U8     ? 1
           : type == ComponentType::I16 || type == ComponentType::U16 ? 2
                                                                      : 4;
}

struct GltfSparse {
    uint64_t count = 0;
    uint32_t index_view = 0;
    uint64_t index_offset = 0;
    ComponentType index_type = ComponentType::U32;
    uint32_t value_view = 0;
    uint64_t value_offset = 0;
};

struct GltfAccessor {
    std::optional<uint32_t> view;  // absent: zeros
    uint64_t offset = 0;
    ComponentType type = ComponentType::F32;
    uint32_t columns = 1;  // matrices; else 1
    uint32_t rows = 1;     // components of a vector, or of a matrix's column
    bool normalized = false;
    uint64_t count = 0;
    std::optional<GltfSparse> sparse;

    uint32_t components() const { return columns * rows; }
    /// Bytes of one column; columns of matrices of small types start on 4-byte boundaries.
    uint32_t column_bytes() const {
        const uint32_t bytes = rows * component_bytes(type);
        return columns > 1 ? (bytes + 3) / 4 * 4 : bytes;
    }
    uint32_t element_bytes() const { return columns * column_bytes(); }
};

struct GltfImage {
    std::string name;
    std::optional<std::string_view> uri;
    std::optional<uint32_t> view;  // exactly one of the two
};

struct GltfTexture {
    std::string name;
    std::optional<uint32_t> image;  // absent: only an unsupported extension says where the image is
    Wrap wrap_s = Wrap::Repeat;
    Wrap wrap_t = Wrap::Repeat;
    bool nearest = false;
};

/// A material whose texture references still count the document's textures and texture coordinate sets.
using GltfMaterial = Material;

struct GltfAttribute {
    std::string_view semantic;
    uint32_t accessor = 0;
};

struct GltfPrimitive {
    std::vector<GltfAttribute> attributes;
    std::optional<uint32_t> indices;
    std::optional<uint32_t> material;
    uint32_t mode = 4;
    std::vector<std::vector<GltfAttribute>> targets;

    std::optional<uint32_t> attribute(std::string_view semantic) const;
};

struct GltfMesh {
    std::string name;
    std::vector<GltfPrimitive> primitives;
    std::vector<float> weights;  // of the morph targets, at rest
};

struct GltfNode {
    std::string name;
    std::vector<uint32_t> children;
    std::optional<uint32_t> parent;
    std::optional<uint32_t> mesh;
    std::optional<uint32_t> skin;
    std::optional<uint32_t> camera;
    std::optional<uint32_t> light;
    dmat4 local{1.0};            // as stored: the pose at rest
    std::vector<float> weights;  // in place of the mesh's, when not empty
};

struct GltfSkin {
    std::vector<uint32_t> joints;
    std::optional<uint32_t> inverse_bind_matrices;
};

struct GltfScene {
    std::string name;
    std::vector<uint32_t> roots;
};

struct GltfDocument {
    std::vector<GltfBuffer> buffers;
    std::vector<GltfBufferView> views;
    std::vector<GltfAccessor> accessors;
    std::vector<GltfImage> images;
    std::vector<GltfTexture> textures;
    std::vector<GltfMaterial> materials;
    std::vector<GltfMesh> meshes;
    std::vector<GltfNode> nodes;
    std::vector<GltfSkin> skins;
    std::vector<Camera> cameras;        // unplaced
    std::vector<PunctualLight> lights;  // unplaced
    std::vector<GltfScene> scenes;
    std::optional<uint32_t> scene;  // the one to load; absent only where there are none
    uint32_t animation_count = 0;
    std::vector<std::string> warnings;
};

/// "/accessors/3" and the like, with further tokens: gltf_pointer("accessors", 3, "sparse", "indices").
template <class... Tokens>
std::string gltf_pointer(std::string_view array, uint64_t index, const Tokens&... tokens) {
    std::string pointer = json_pointer_token(array) + json_pointer_token(std::to_string(index));
    ((pointer += json_pointer_token(tokens)), ...);
    return pointer;
}

/// Reads and checks a whole document. The result borrows the strings of `json`. Throws one photond::Error that names
/// all faults found: ErrorCode::Unsupported for an extension required but not supported, else ErrorCode::BadScene.
GltfDocument read_gltf_document(const JsonDocument& json);

// What read_gltf_document() is made of.

/// Whether `extensionsUsed` or `extensionsRequired` lists the extension.
bool lists_extension(const JsonRef& root, std::string_view name);
/// Buffers, buffer views, accessors, images, samplers and textures (gltf_read_data.cpp).
void read_gltf_data(const JsonRef& root, GltfDocument& document, FaultList& faults);
/// Materials with their extensions (gltf_material.cpp).
void read_gltf_materials(const JsonRef& root, GltfDocument& document, FaultList& faults);
/// Meshes and skins, whose accessors must exist and fit their use (gltf_read_meshes.cpp).
void read_gltf_meshes(const JsonRef& root, GltfDocument& document, FaultList& faults);
/// Nodes, scenes, cameras, lights, animations (gltf_read_nodes.cpp).
void read_gltf_nodes(const JsonRef& root, GltfDocument& document, FaultList& faults);

}  // namespace photond

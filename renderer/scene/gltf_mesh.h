#pragma once
// From a glTF primitive to a Mesh in object space: triangles of any topology, only the vertices they use, checked.

#include <optional>

#include "renderer/scene/gltf_accessor.h"
#include "renderer/scene/object_mesh.h"

namespace photond {

/// What was left out while reading, for the scene's warnings.
struct MeshTally {
    uint64_t degenerate_triangles = 0;
    uint64_t points_and_lines = 0;  // primitives
    uint64_t clamped_colors = 0;    // vertices
    uint64_t missing_uv_sets = 0;   // primitives whose material reads coordinates they do not have
    uint64_t bad_normals = 0;       // vertices whose normal had no direction
    uint64_t unweighted = 0;        // vertices whose weights are all 0
};

/// Which of the document's texture coordinate sets the material's slots 0 and 1 hold.
struct UvSlots {
    std::optional<uint32_t> set[2];
};

/// What a primitive's material asks of the mesh.
struct MeshWants {
    UvSlots uv;
    const TextureRef* normal_texture = nullptr;  // slots already mapped; null: no tangents wanted
};

/// The number of triangles a primitive says it has; 0 for points and lines.
uint64_t promised_triangles(const tinygltf::Primitive& primitive, const tinygltf::Model& model);

/// What of a mesh matters to the nodes that show it.
struct MeshShape {
    size_t joints = 0;                  // that a vertex may name; 0 where no skin moves the mesh
    std::span<const uint32_t> targets;  // morph targets that have a weight, or are given one by an animation
};

/// Reads primitive `primitive` of mesh `mesh`. Throws ErrorCode::BadScene for positions and displacements that are not
/// finite, for indices out of range, and for morph targets beyond what GltfData::charge() allows.
ObjectMesh read_primitive_mesh(const GltfDocument& document, GltfData& data, uint32_t mesh, uint32_t primitive,
                               const MeshShape& shape, const MeshWants& wants, MeshTally& tally);

/// Per-vertex tangents that follow the coordinates of `normal_texture` (KHR_texture_transform included), area-weighted,
/// vertices split where the handedness changes. A mesh without normals gets three vertices a triangle. Gives the vertex
/// that each was before; empty where none was added.
std::vector<uint32_t> build_tangents(Mesh& mesh, const TextureRef& normal_texture);
/// Of a mesh that will move: those of its stored shape, which its targets and joints move with it.
void build_tangents(ObjectMesh& object, const TextureRef& normal_texture);

}  // namespace photond

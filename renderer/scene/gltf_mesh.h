#pragma once
// From a glTF primitive to a Mesh in object space: triangles of any topology, only the vertices they use, checked.

#include <optional>

#include "renderer/scene/gltf_accessor.h"
#include "renderer/scene/scene.h"

namespace photond {

/// What was left out while reading, for the scene's warnings.
struct MeshTally {
    uint64_t degenerate_triangles = 0;
    uint64_t points_and_lines = 0;  // primitives
    uint64_t clamped_colors = 0;    // vertices
    uint64_t missing_uv_sets = 0;   // primitives whose material reads coordinates they do not have
    uint64_t bad_normals = 0;       // vertices whose normal had no direction
};

/// One joint's influence on a vertex.
struct JointWeight {
    uint32_t joint = 0;
    float weight = 0;
};

/// A primitive as read, before it is placed.
struct ObjectMesh {
    Mesh mesh;                            // object space, morph targets applied at their rest weights
    uint32_t joint_sets = 0;              // influences a vertex / 4
    std::vector<JointWeight> influences;  // 4 x joint_sets a vertex; weights sum to 1
    uint64_t dropped = 0;                 // degenerate triangles
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

/// Reads primitive `primitive` of mesh `mesh`. `weights`: of its morph targets. Throws ErrorCode::BadScene for
/// positions that are not finite and indices out of range. Triangles without area are dropped; there may be none left.
ObjectMesh read_primitive_mesh(const GltfDocument& document, GltfData& data, uint32_t mesh, uint32_t primitive,
                               std::span<const double> weights, const MeshWants& wants, MeshTally& tally);

/// Drops triangles without area: two equal corners, or an area so small that no normal can be had in float.
uint64_t drop_degenerate_triangles(Mesh& mesh);

/// Per-vertex tangents that follow the coordinates of `normal_texture` (KHR_texture_transform included), area-weighted,
/// vertices split where the handedness changes. A mesh without normals gets three vertices a triangle.
void build_tangents(Mesh& mesh, const TextureRef& normal_texture);

}  // namespace photond

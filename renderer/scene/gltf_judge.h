#pragma once
// The judge of a glTF 2.0 document. After it, every index is in range, every number is finite and within the
// specification's range, every byte range lies inside its buffer's stated length, the node hierarchy is a forest.
// Nothing of a buffer's or image's contents has been looked at yet.

#include "renderer/scene/gltf_json.h"

namespace photond {

/// Judges the whole document and makes it plain (gltf_schema.h); adds a warning for each extension that is ignored.
/// Throws one photond::Error that names all faults found: ErrorCode::Unsupported for an extension required but not
/// supported, else ErrorCode::BadScene.
void judge_gltf(Json& document, std::vector<std::string>& warnings);

// What holds of a sound value beyond the table: rules across members, and between one part of the document and
// another. Each throws its first fault.
namespace gltf_rules {

bool lists_extension(const Json& root, std::string_view name);
/// The morph targets of a primitive; those of one without positions, or of a faulty one, do not count.
size_t target_count(const Json& primitive);

// gltf_rules_data.cpp
void buffer_view(const Json& root, const Json& view);
void accessor(const Json& root, const Json& accessor);
void image(const Json& root, const Json& image);
// gltf_rules_meshes.cpp
void primitive(const Json& root, const Json& primitive);
void mesh(const Json& root, const Json& mesh);
void skin(const Json& root, const Json& skin);
void material(const Json& root, const Json& material);
// gltf_rules_nodes.cpp
void camera(const Json& root, const Json& camera);
void light(const Json& root, const Json& light);
void node(const Json& root, const Json& node);
void nodes(const Json& root, const Json& nodes);
void scenes(const Json& root, const Json& scenes);
void animation(const Json& root, const Json& animation);

}  // namespace gltf_rules

}  // namespace photond

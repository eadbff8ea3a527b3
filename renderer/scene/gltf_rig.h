#pragma once
// Nodes, skins, cameras, lights and animations of a document, as a rig.

#include "renderer/scene/gltf_accessor.h"
#include "renderer/scene/rig.h"

namespace photond {

/// Of the document's default scene; its meshes and materials are left to who places them, so that channels of materials
/// count the document's. Throws ErrorCode::BadScene with the place for keys that are not finite or go back in time.
Rig read_gltf_rig(const GltfDocument& document, GltfData& data, std::vector<std::string>& warnings);

/// gltf_animation.cpp's part of it.
std::vector<Animation> read_gltf_animations(const GltfDocument& document, GltfData& data,
                                            std::vector<std::string>& warnings);

}  // namespace photond

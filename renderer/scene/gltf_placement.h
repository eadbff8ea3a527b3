#pragma once
// From a document's default scene to a Scene: the node hierarchy walked in double, meshes baked or instanced, cameras
// and lights placed, the whole re-centred where it lies too far from the origin for float coordinates.

#include "renderer/scene/gltf_accessor.h"
#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/scene.h"

namespace photond {

/// Fills meshes, instances, materials, cameras, lights, origin and warnings. The materials' texture references still
/// count the document's textures. Gives what moves, for adopt_rig(), without its materials as they are at rest; null
/// where nothing is animated. Throws ErrorCode::BadScene with the place.
std::shared_ptr<Rig> place_gltf_scene(const GltfDocument& document, GltfData& data, const LoadLimits& limits,
                                      Scene& scene);

/// Decodes the images that the scene's materials use, in parallel, and points the materials at them. Throws
/// ErrorCode::BadImage with the place of each image that is not accepted.
void load_gltf_textures(const GltfDocument& document, GltfData& data, const ImageDecoder& decode,
                        const LoadLimits& limits, Scene& scene);

}  // namespace photond

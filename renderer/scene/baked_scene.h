#pragma once
// A scene as one file that needs no image or glTF library to be read: geometry, materials, lights, cameras and decoded
// textures as they are in memory. For carrying scenes to machines that have only photond-gpu-bench.

#include <filesystem>

#include "renderer/scene/scene.h"

namespace photond {

/// Writes a finished scene: whole or not at all. The file is this version's own and of this machine's byte order.
void write_baked_scene(const Scene& scene, const std::filesystem::path& file);

/// The scene, finished. Throws ErrorCode::BadScene, naming file and place, for what is not a whole baked scene of this
/// version or refers to what is not in it.
Scene read_baked_scene(const std::filesystem::path& file);

}  // namespace photond

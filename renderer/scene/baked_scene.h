#pragma once
// A scene as one file that needs no image or glTF library to be read: geometry, materials, lights, cameras and decoded
// textures as they are in memory. For carrying scenes to machines that have only photond-gpu-bench.

#include <cstdint>
#include <filesystem>

namespace photond {

struct Scene;

/// Bytes of the file that write_baked_scene() makes.
uint64_t baked_scene_bytes(const Scene& scene);

/// Writes a finished scene: whole or not at all. The file is this version's own and of this machine's byte order; the
/// same scene makes the same bytes. What was said about the file the scene came from (its size, warnings, animations)
/// stays behind. Throws ErrorCode::NoSpace or ErrorCode::Internal, as AtomicFile does.
void write_baked_scene(const Scene& scene, const std::filesystem::path& file);

/// The scene, finished. Throws ErrorCode::BadScene, naming the file and what is wrong with it, for what is not a whole
/// baked scene of this version, refers to what is not in it, or has numbers that are none; the memory that takes is
/// bounded by a small multiple of the file, whatever counts it claims.
Scene read_baked_scene(const std::filesystem::path& file);

}  // namespace photond

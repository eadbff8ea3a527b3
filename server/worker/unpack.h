#pragma once
#include <cstdint>
#include <filesystem>

namespace photond {

/// Limits against archives that ask for more than they are worth.
struct UnpackLimits {
    uint64_t max_entries = 10'000;
    uint64_t max_total_bytes = 8ull << 30;  // unpacked, as stated and as found
    uint64_t max_ratio = 200;               // of an entry over kRatioFreeBytes: unpacked to packed
    uint64_t ratio_free_bytes = 1 << 20;
};

/// Unpacks a ZIP below `root`, an existing empty folder, and returns its scene: the one .gltf or .glb in the topmost
/// folder that holds any. Everything is judged by what the archive's directory states before a byte is unpacked, and
/// held to it while unpacking. Throws ErrorCode::BadScene: not a ZIP, encrypted, an unknown packing, an entry that is
/// no regular file or folder, a path that is absolute or leaves `root`, two entries of one name, past a limit, not
/// exactly one scene; PayloadTooLarge for the total; NoSpace.
std::filesystem::path unpack_scene(const std::filesystem::path& zip, const std::filesystem::path& root,
                                   const UnpackLimits& limits = {});

}  // namespace photond

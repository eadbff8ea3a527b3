#pragma once
// The scenes that benchmarks measure on. Those beside the repository are optional.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/texture_decode.h"

namespace photond {

inline double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

/// A scene to measure on, with the size of its picture.
struct NamedScene {
    const char* name;
    const char* file;  // in the folder of scene files; null: built in
    Size2 size;
};
inline constexpr NamedScene kBenchScenes[] = {{"cornell-box", nullptr, {256, 256}},
                                              {"interior", nullptr, {320, 240}},
                                              {"cornell_diffuse_dragon", "cornell_diffuse_dragon.glb", {256, 256}},
                                              {"sponza_crytek", "sponza_crytek.glb", {384, 216}}};

/// Nothing, with a line that says so, where the scene is not there.
inline std::optional<Scene> open(const NamedScene& named) {
    if (!named.file) return make_builtin_scene(named.name);
    const std::filesystem::path folder = std::filesystem::path(PHOTOND_SHARED) / "scenes";
    if (!std::filesystem::exists(folder / named.file)) {
        std::printf("%-24s skipped: %s is not there\n", named.name, (folder / named.file).c_str());
        return {};
    }
    return load_gltf(folder / named.file, folder, decode_texture);
}

inline std::unique_ptr<Intersector> build(const Scene& scene) {
    MemoryBudget budget;
    Stats stats;
    return make_embree_intersector(scene, budget, stats);
}

}  // namespace photond

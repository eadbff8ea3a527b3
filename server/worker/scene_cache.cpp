#include "server/worker/scene_cache.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "protocol/error.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/backends/gpu/device.h"
#include "renderer/backends/gpu/device_intersector.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/solid_glass.h"
#include "renderer/scene/texture_decode.h"
#include "renderer/voxels/kept_voxels.h"
#include "server/device_memory.h"
#include "server/worker/process_memory.h"

namespace photond {

using nlohmann::json;

namespace {

EnvironmentMap read_environment(const std::filesystem::path& path) {
    const LoadLimits limits;
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) throw Error(ErrorCode::BadImage, "/environment/image", "the environment image cannot be opened");
    const auto bytes = static_cast<uint64_t>(file.tellg());
    if (bytes > limits.max_file_bytes)
        throw Error(ErrorCode::BadImage, "/environment/image",
                    "the environment image has " + std::to_string(bytes) + " bytes; the limit is " +
                        std::to_string(limits.max_file_bytes));
    std::vector<uint8_t> encoded(bytes);
    file.seekg(0);
    file.read(reinterpret_cast<char*>(encoded.data()), static_cast<std::streamsize>(bytes));
    if (!file) throw Error(ErrorCode::BadImage, "/environment/image", "the environment image cannot be read");
    return decode_environment(encoded, limits);
}

void light_if_dark(Scene& scene) {
    const Needs& needs = scene.needs;
    if (needs.area_lights || needs.punctual_lights || needs.environment || needs.unlit) return;
    Environment sky;
    sky.map.size = {2, 1};
    sky.map.radiance.assign(2, Rgb(1));
    scene.environment = std::move(sky);
    scene.needs = find_needs(scene);
}

/// Throws ErrorCode::UnknownName for an animation that the scene does not have.
Moment moment_of(const SceneMoment& wanted, const Scene& scene) {
    if (!wanted.animation) return {};
    std::vector<std::string> names;
    if (scene.rig)
        for (const Animation& animation : scene.rig->animations) names.push_back(animation.name);
    check_animation(*wanted.animation, names);
    if (wanted.animation->index) return {*wanted.animation->index, wanted.time_s};
    const auto found = std::find(names.begin(), names.end(), wanted.animation->name);
    return {static_cast<uint32_t>(found - names.begin()), wanted.time_s};
}

SceneChange pose_timed(Scene& scene, const Moment& moment, Stats& stats) {
    const StageTimer timer(stats, "pose");
    return pose_scene(scene, moment);
}

uint64_t sum_of(const std::map<std::string, uint64_t>& structures) {
    uint64_t sum = 0;
    for (const auto& [name, bytes] : structures) sum += bytes;
    return sum;
}

}  // namespace

ReadyScene::ReadyScene() : kept_voxels(std::make_unique<KeptVoxels>()) {}
ReadyScene::~ReadyScene() = default;

uint64_t ReadyScene::bytes() const { return sum_of(structures); }
uint64_t ReadyScene::kept_bytes() const { return kept_voxels->bytes(); }
uint64_t ReadyScene::kept_device_bytes() const { return sum_of(kept_voxels->device_structures()); }
uint64_t ReadyScene::device_bytes() const { return sum_of(device_structures); }

Scene load_scene(const SceneSource& source, const SceneVariant& variant, Stats& stats) {
    Scene scene;
    {
        const StageTimer timer(stats, "load");
        scene = source.builtin.empty() ? load_gltf(source.file, source.root, decode_texture)
                                       : make_builtin_scene(source.builtin);
        if (!variant.environment_path.empty()) {
            Environment environment;
            environment.map = read_environment(variant.environment_path);
            environment.scale = static_cast<float>(variant.environment_scale);
            environment.rotation = static_cast<float>(variant.environment_rotation);
            scene.environment = std::move(environment);
        }
        // What the file and its decoders needed is free by now: not this job's memory any more.
        release_free_memory();
    }
    const StageTimer timer(stats, "needs");
    if (variant.solid_glass && make_closed_glass_solid(scene)) finish_scene(scene);  // solids that touch
    if (scene.environment) scene.needs = find_needs(scene);
    if (variant.light_if_dark) light_if_dark(scene);
    return scene;
}

std::string SceneCache::key_of(const SceneSource& source, const SceneVariant& variant) {
    return json{source.id,
                source.builtin,
                source.file.string(),
                variant.environment_id,
                variant.environment_path.string(),
                variant.environment_scale,
                variant.environment_rotation,
                variant.solid_glass,
                variant.light_if_dark}
        .dump();
}

bool SceneCache::holds(const SceneSource& source, const SceneVariant& variant) const {
    const std::string key = key_of(source, variant);
    return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
}

std::shared_ptr<const ReadyScene> SceneCache::get(const SceneSource& source, const SceneVariant& variant,
                                                  MemoryBudget& budget, Stats& stats, bool on_host,
                                                  const SceneMoment& wanted) {
    const std::string key = key_of(source, variant);
    evict_idle(key);
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
        if (entry->key != key) continue;
        entries_.splice(entries_.begin(), entries_, entry);
        show_first(wanted, budget.limit_bytes(), stats);
        if (on_host) add_host_rays(*entry->ready, budget.limit_bytes(), stats);
        if (entry->ready->bytes() > budget.limit_bytes()) budget.require("scene", entry->ready->bytes());
        for (const auto& [name, bytes] : entry->ready->structures) budget.record(name, bytes);
        return entry->ready;
    }
    const std::shared_ptr<ReadyScene> ready = std::make_shared<ReadyScene>();
    ready->scene = load_scene(source, variant, stats);
    pose_timed(ready->scene, moment_of(wanted, ready->scene), stats);
    make_ready(*ready, budget.limit_bytes(), stats);
    if (on_host) add_host_rays(*ready, budget.limit_bytes(), stats);
    for (const auto& [name, bytes] : ready->structures) budget.record(name, bytes);
    entries_.push_front({key, ready});
    return ready;
}

void SceneCache::make_ready(ReadyScene& ready, uint64_t limit_bytes, Stats& stats) const {
    MemoryBudget budget(limit_bytes);
    ready.scene.account(budget);
    budget.require("scene", 0);
    ready.host_intersector = nullptr;
    ready.intersector = nullptr;
    if (device_) {
        ready.device_scene = nullptr;
        ready.device_scene = std::make_unique<gpu::DeviceScene>(*device_, ready.scene, stats);
        ready.device_structures = ready.device_scene->structures();
        ready.intersector = std::make_unique<gpu::DeviceIntersector>(*ready.device_scene);
        release_free_memory();  // what building and sending it needed
    } else {
        ready.intersector = make_embree_intersector(ready.scene, budget, stats);
    }
    ready.structures = budget.structures();
}

void SceneCache::pose(ReadyScene& ready, const Moment& moment, uint64_t limit_bytes, Stats& stats) const {
    if (ready.scene.moment == moment) return;
    ready.host_intersector = nullptr;  // whoever asks for it gets one of this moment
    const SceneChange change = pose_timed(ready.scene, moment, stats);
    ready.kept_voxels->note(change);
    MemoryBudget budget(limit_bytes);
    ready.scene.account(budget);
    if (device_) {
        ready.intersector = nullptr;
        ready.device_scene->follow(change, stats);
        ready.device_structures = ready.device_scene->structures();
        ready.intersector = std::make_unique<gpu::DeviceIntersector>(*ready.device_scene);
    } else {
        follow_pose(ready.intersector, ready.scene, change, budget, stats);
    }
    ready.structures = budget.structures();
}

void SceneCache::show(const SceneMoment& moment, MemoryBudget& budget, Stats& stats) {
    show_first(moment, budget.limit_bytes(), stats);
    for (const auto& [name, bytes] : entries_.front().ready->structures) budget.record(name, bytes);
}

void SceneCache::show_first(const SceneMoment& wanted, uint64_t limit_bytes, Stats& stats) {
    ReadyScene& ready = *entries_.front().ready;
    const bool on_host = ready.host_intersector != nullptr;
    try {
        pose(ready, moment_of(wanted, ready.scene), limit_bytes, stats);
        if (on_host) add_host_rays(ready, limit_bytes, stats);
    } catch (...) {            // memory that has run out is no Error
        entries_.pop_front();  // what is half of one moment and half of another
        throw;
    }
}

void SceneCache::add_host_rays(ReadyScene& ready, uint64_t limit_bytes, Stats& stats) const {
    if (!device_ || ready.host_intersector) return;
    MemoryBudget budget(limit_bytes);
    for (const auto& [name, bytes] : ready.structures) budget.record(name, bytes);
    ready.host_intersector = make_embree_intersector(ready.scene, budget, stats);
    ready.structures = budget.structures();
}

uint64_t SceneCache::bytes() const {
    uint64_t bytes = 0;
    for (const Entry& entry : entries_) bytes += entry.ready->bytes() + entry.ready->kept_bytes();
    return bytes;
}

void SceneCache::evict_idle(const std::string& wanted_key) {
    const uint64_t idle_device_bytes = device_ ? device_->memory_limit_bytes() / kIdleDeviceScenesDivisor : 0;
    uint64_t idle = 0, idle_on_device = 0;
    for (auto entry = entries_.begin(); entry != entries_.end();) {
        const uint64_t bytes = entry->ready->bytes(), device_bytes = entry->ready->device_bytes();
        const bool fits = idle + bytes <= idle_bytes_ && idle_on_device + device_bytes <= idle_device_bytes;
        if (entry->key != wanted_key && !fits) {
            entry = entries_.erase(entry);
            continue;
        }
        if (entry->key != wanted_key) idle += bytes, idle_on_device += device_bytes;
        if (idle + entry->ready->kept_bytes() > idle_bytes_ ||
            idle_on_device + entry->ready->kept_device_bytes() > idle_device_bytes)
            entry->ready->kept_voxels->clear();
        idle += entry->ready->kept_bytes(), idle_on_device += entry->ready->kept_device_bytes();
        ++entry;
    }
}

}  // namespace photond

#pragma once
// A scene on a device: uploaded once, then only read, by all shaders (descriptor set 1, scene_bindings.h).

#include <array>
#include <map>
#include <optional>
#include <vector>

#include "renderer/backends/gpu/pipeline.h"
#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/core/stats.h"

namespace photond {
struct Scene;
struct SceneChange;
}  // namespace photond

namespace photond::gpu {

class DeviceScene {
public:
    /// Of a finished scene; borrows both, which must stay. Building the ray structure is timed as stage
    /// `acceleration_build`, everything else as `scene_upload`. Throws ErrorCode::OutOfMemory, naming the structure
    /// with its bytes and the limit, when one is more than the device may hold or its shaders can see in one buffer.
    DeviceScene(Device& device, const Scene& scene, Stats& stats);
    DeviceScene(Device& device, const Scene& scene) : DeviceScene(device, scene, Stats()) {}
    DeviceScene(const DeviceScene&) = delete;
    DeviceScene& operator=(const DeviceScene&) = delete;

    /// After pose_scene() changed the scene: what moved, and what follows from it, is uploaded again; textures and what
    /// lies still stay. Timed as when it was built. Nothing may be running that reads it.
    void follow(const SceneChange& change, Stats& stats);

    Device& device() const { return device_; }
    const Scene& scene() const { return scene_; }

    /// The scene's buffers, for pipelines whose shaders read it.
    const BufferSet& set() const { return *set_; }
    /// What the scene needs, as constants 0 to 31 of such shaders (scene.glsl).
    std::span<const Specialization> specialization() const { return specialization_; }
    /// These constants and a method's own.
    std::vector<Specialization> specialization(std::span<const Specialization> more) const;

    /// Device bytes, as Device::memory() accounts them: in all, and by structure.
    uint64_t bytes() const;
    std::map<std::string, uint64_t> structures() const;

private:
    DeviceScene(Device& device, const Scene& scene, Stats&& unused) : DeviceScene(device, scene, unused) {}
    static std::array<Buffer, SCENE_BINDINGS> upload_all(Device& device, const Scene& scene, Stats& stats);
    void bind_all();

    Device& device_;
    const Scene& scene_;
    std::array<Buffer, SCENE_BINDINGS> buffers_;  // by binding
    std::optional<BufferSet> set_;
    std::vector<Specialization> specialization_;
};

}  // namespace photond::gpu

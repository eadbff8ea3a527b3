#pragma once
// Scenes kept ready between jobs: loaded, with their ray structure built, on a GPU where the worker has one.

#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "protocol/job.h"
#include "protocol/message_parts.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace gpu {
class Device;
class DeviceScene;
}  // namespace gpu
class KeptVoxels;

/// What a job changes about a scene.
struct SceneVariant {
    std::string environment_id;              // empty: the scene's own
    std::filesystem::path environment_path;  // of its file
    double environment_scale = 1;
    double environment_rotation = 0;  // radians about +Y
    bool solid_glass = false;
    bool light_if_dark = false;  // a white sky for a scene that brings no light: of pictures to recognise it by
};

/// Which moment of it.
struct SceneMoment {
    std::optional<JobAnimation> animation;  // none: at rest
    double time_s = 0;
};

/// A scene and its ray structure, and what each part of them takes.
struct ReadyScene {
    Scene scene;
    std::unique_ptr<gpu::DeviceScene> device_scene;  // null on the CPU
    std::unique_ptr<Intersector> intersector;        // on a GPU answered by it
    std::unique_ptr<Intersector> host_intersector;   // on a GPU, once a job asks for rays on the cores too
    std::unique_ptr<KeptVoxels> kept_voxels;         // what methods leave to the next frame; never null
    std::map<std::string, uint64_t> structures;      // of the host
    std::map<std::string, uint64_t> device_structures;

    ReadyScene();
    ~ReadyScene();
    // Without what is kept of voxels, and that alone, which can be let go at no loss but time: of the host, then of the
    // device.
    uint64_t bytes() const;
    uint64_t kept_bytes() const;
    uint64_t device_bytes() const;
    uint64_t kept_device_bytes() const;
};

/// Loads or makes a scene, changed as the job asks. Stages `load` and, where it was changed, `needs`. Throws
/// photond::Error: BadScene with pointers into the glTF, BadImage for the environment.
Scene load_scene(const SceneSource& source, const SceneVariant& variant, Stats& stats);

/// The last scene used, and older ones as long as together they hold at most `idle_bytes`, and of a device's memory the
/// share that is not one job's (device_memory.h); the least recently used go first.
/// What methods kept of their voxels is held as long as it fits in besides. Not thread-safe: one job runs at a time.
class SceneCache {
public:
    /// `device`: what its scenes are made ready for, borrowed; null: the CPU.
    explicit SceneCache(uint64_t idle_bytes, gpu::Device* device = nullptr)
        : idle_bytes_(idle_bytes), device_(device) {}

    /// Whether get() would find it loaded, at whatever moment.
    bool holds(const SceneSource& source, const SceneVariant& variant) const;
    /// The scene at that moment, from memory or loaded now; its structures on the host are recorded in `budget`.
    /// `on_host`: with a host_intersector where it is on a GPU. What is there and shows another moment is posed, stage
    /// `pose`, and its structures follow: what was got before must be let go by then. Throws what load_scene() and
    /// pose_scene() throw, UnknownName for an animation that the scene does not have, and OutOfMemory when it does not
    /// fit the budget.
    std::shared_ptr<const ReadyScene> get(const SceneSource& source, const SceneVariant& variant, MemoryBudget& budget,
                                          Stats& stats, bool on_host = false, const SceneMoment& moment = {});
    /// Shows another moment of what get() gave last, whose structures are recorded in `budget` again. Nobody may be
    /// using them.
    void show(const SceneMoment& moment, MemoryBudget& budget, Stats& stats);
    void clear() { entries_.clear(); }
    uint64_t bytes() const;  // of the host, of all scenes held

private:
    struct Entry {
        std::string key;
        std::shared_ptr<ReadyScene> ready;
    };
    static std::string key_of(const SceneSource& source, const SceneVariant& variant);
    /// Whatever follows from the scene, built from it as it is now.
    void make_ready(ReadyScene& ready, uint64_t limit_bytes, Stats& stats) const;
    void pose(ReadyScene& ready, const Moment& moment, uint64_t limit_bytes, Stats& stats) const;
    /// Of the first entry, which is forgotten where it fails.
    void show_first(const SceneMoment& wanted, uint64_t limit_bytes, Stats& stats);
    void add_host_rays(ReadyScene& ready, uint64_t limit_bytes, Stats& stats) const;
    void evict_idle(const std::string& wanted_key);

    const uint64_t idle_bytes_;
    gpu::Device* const device_;
    std::list<Entry> entries_;  // the last used first
};

}  // namespace photond

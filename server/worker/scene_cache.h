#pragma once
// Scenes kept ready between jobs: loaded, with their ray structure built.

#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "protocol/job.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"

namespace photond {

/// Where a scene comes from, as "scene" in a render order says it.
struct SceneSource {
    std::string id;
    std::string builtin;  // empty: from a file
    std::filesystem::path root;
    std::filesystem::path file;

    static SceneSource from_json(const nlohmann::json& json);
};

/// What a job changes about a scene.
struct SceneVariant {
    std::string environment_id;              // empty: the scene's own
    std::filesystem::path environment_path;  // of its file
    double environment_scale = 1;
    double environment_rotation = 0;  // radians about +Y
    bool solid_glass = false;
    double time_s = 0;
};

/// A scene and its ray structure, and what each part of them takes.
struct ReadyScene {
    Scene scene;
    std::unique_ptr<Intersector> intersector;
    std::map<std::string, uint64_t> structures;

    uint64_t bytes() const;
};

/// Loads or makes a scene, changed as the job asks. Stages `load` and, where it was changed, `needs`. Throws
/// photond::Error: BadScene with pointers into the glTF, BadImage for the environment.
Scene load_scene(const SceneSource& source, const SceneVariant& variant, Stats& stats);

/// The last scene used, and older ones as long as together they hold at most `idle_bytes`; the least recently used go
/// first. Not thread-safe: one job runs at a time.
class SceneCache {
public:
    explicit SceneCache(uint64_t idle_bytes) : idle_bytes_(idle_bytes) {}

    /// Whether get() would find it ready.
    bool holds(const SceneSource& source, const SceneVariant& variant) const;
    /// Bytes of the scene if it is ready, else 0.
    uint64_t bytes_of(const SceneSource& source, const SceneVariant& variant) const;
    /// The scene, from memory or loaded now; its structures are recorded in `budget`. Throws what load_scene() throws,
    /// and OutOfMemory when it does not fit the budget.
    std::shared_ptr<const ReadyScene> get(const SceneSource& source, const SceneVariant& variant, MemoryBudget& budget,
                                          Stats& stats);
    void clear() { entries_.clear(); }

private:
    struct Entry {
        std::string key;
        std::shared_ptr<const ReadyScene> ready;
    };
    static std::string key_of(const SceneSource& source, const SceneVariant& variant);
    void evict_idle(const std::string& wanted_key);

    const uint64_t idle_bytes_;
    std::list<Entry> entries_;  // the last used first
};

}  // namespace photond

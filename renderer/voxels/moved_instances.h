#pragma once
// Which instances of a moving scene are not voxelised as they were when they were asked for last.

#include <cstdint>
#include <vector>

namespace photond {

struct Scene;
struct SceneChange;  // scene/pose.h

/// Beside one scene, which always has the same instances. Not thread-safe.
class MovedInstances {
public:
    /// To be told whatever pose_scene() gives.
    void note(const SceneChange& change);
    /// Since settle(), which was called before: rising numbers.
    std::vector<uint32_t> list(const Scene& scene) const;
    /// As the scene is now nothing has moved.
    void settle(const Scene& scene);

private:
    std::vector<bool> voxelised_;  // instances: whether they were
    std::vector<uint32_t> moved_meshes_;
};

}  // namespace photond

#pragma once
// What a moving scene's octree leaves to that of its next frame: what each instance has in its bricks, of which only
// that of instances that changed is found again. The tree has the bits of one that is built anew.

#include <optional>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

struct SceneChange;  // scene/pose.h

/// Beside one scene, which always has the same instances. Not thread-safe.
class KeptVoxels {
public:
    /// To be told whatever pose_scene() gives, before octree() is asked again.
    void note(const SceneChange& change);

    /// Of the scene as it is now. Stage `svo_update` where it follows from the last one, which had the same grid and
    /// has surfaces as this one has; else `svo_build`. Kept is what moves and takes no more than an eighth of what the
    /// budget has left.
    SparseVoxelOctree octree(const Scene& scene, const VoxelGrid& grid, bool surfaces, MemoryBudget& budget,
                             Stats& stats);

    uint64_t bytes() const;
    void clear();

private:
    bool holds(const VoxelGrid& grid, bool surfaces) const;
    std::vector<uint32_t> changed_instances(const Scene& scene) const;

    std::optional<InstanceBricks> parts_;
    std::vector<bool> voxelised_;         // instances: whether they were, in parts_
    std::vector<uint32_t> moved_meshes_;  // since parts_ were as the scene
};

/// An octree by what is kept; null: nothing is. Both are recorded in `budget`. Throws ErrorCode::OutOfMemory where
/// building the tree may take more than the budget has.
SparseVoxelOctree make_octree(KeptVoxels* kept, const Scene& scene, const VoxelGrid& grid, bool surfaces,
                              MemoryBudget& budget, Stats& stats);

}  // namespace photond

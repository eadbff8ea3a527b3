#pragma once
// What a moving scene's octree leaves to that of its next frame: what each instance has in its bricks, of which only
// that of instances that changed is found again. The tree has the bits of one that is built anew. On a device it is
// what kept_voxels_gpu.h says.

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/voxels/moved_instances.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

class KeptVoxelsGpu;

/// Beside one scene, which always has the same instances. Not thread-safe.
class KeptVoxels {
public:
    KeptVoxels();
    ~KeptVoxels();

    /// To be told whatever pose_scene() gives, before octree() is asked again.
    void note(const SceneChange& change);

    /// Of the scene as it is now. Stage `svo_update` where it follows from the last one, which had the same grid and
    /// has surfaces as this one has; else `svo_build`. Kept is what moves and takes no more than an eighth of what the
    /// budget has left.
    SparseVoxelOctree octree(const Scene& scene, const VoxelGrid& grid, bool surfaces, MemoryBudget& budget,
                             Stats& stats);

    /// Of the scene on its device, which must stay until clear().
    KeptVoxelsGpu& on_device();

    uint64_t bytes() const;  // of the host
    std::map<std::string, uint64_t> device_structures() const;
    void clear();

    /// Whether so much may be kept where so much is left.
    static bool may_keep(uint64_t bytes, uint64_t rest_bytes);

private:
    bool holds(const VoxelGrid& grid, bool surfaces) const;

    std::optional<InstanceBricks> parts_;
    MovedInstances moved_;  // since parts_ were as the scene
    std::unique_ptr<KeptVoxelsGpu> on_device_;
};

/// An octree by what is kept; null: nothing is. Both are recorded in `budget`. Throws ErrorCode::OutOfMemory where
/// building the tree may take more than the budget has.
SparseVoxelOctree make_octree(KeptVoxels* kept, const Scene& scene, const VoxelGrid& grid, bool surfaces,
                              MemoryBudget& budget, Stats& stats);

}  // namespace photond

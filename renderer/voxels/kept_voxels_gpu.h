#pragma once
// KeptVoxels of a device: the tree of a moving scene's last frame, and the bricks of what does not move, from which the
// next one follows. What has moved lately is voxelised in each frame; all else is still.

#include <map>
#include <memory>
#include <string>

#include "renderer/voxels/moved_instances.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"

namespace photond {

class KeptVoxels;

/// Beside one scene on a device, which always has the same instances. Not thread-safe.
class KeptVoxelsGpu {
public:
    KeptVoxelsGpu() = default;
    KeptVoxelsGpu(const KeptVoxelsGpu&) = delete;
    KeptVoxelsGpu& operator=(const KeptVoxelsGpu&) = delete;

    /// To be told whatever pose_scene() gives, before octree() is asked again.
    void note(const SceneChange& change);

    /// Of the scene as it is now, with the bits of a tree that is built anew. It may be under way (settle()), for that
    /// no frame waits but the one in which other things move than before. Whoever had one before must have let it go.
    ///
    /// Where something moves that was still, it is built anew (stages `voxelise` and `svo_build`); so it is where the
    /// grid, the triangles or what their voxels ask for are others, or more than half of the triangles move. Where the
    /// same move the next time, what is still is built and kept; from then on the tree follows (stages `voxelise` and
    /// `svo_update`), and where nothing moved it is as it was. What came to rest is still again once it has cost as
    /// much as finding that. Kept is what moves, and takes no more than an eighth of what the device has left.
    std::shared_ptr<SparseVoxelOctreeGpu> octree(const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces,
                                                 Stats& stats);

    /// On the device, by structure.
    std::map<std::string, uint64_t> structures() const;
    void clear();

private:
    void follow(SparseVoxelOctreeGpu& tree, const Scene& scene, Stats& stats);

    std::shared_ptr<SparseVoxelOctreeGpu> tree_;
    MovedInstances moved_;
    std::vector<uint32_t> moving_;    // all others are still
    uint64_t resting_triangles_ = 0;  // of moving_ that did not move, in all frames since
    bool came_to_rest_ = false;       // something, so that what the tree keeps is not all that is still
};

/// The tree of one frame, or none where nobody asks for one. Its going waits for what is under way, for the scene may
/// change then.
class FrameOctreeGpu {
public:
    FrameOctreeGpu() = default;
    FrameOctreeGpu(FrameOctreeGpu&&) = default;
    FrameOctreeGpu& operator=(FrameOctreeGpu&& other) noexcept;
    ~FrameOctreeGpu();
    /// As KeptVoxelsGpu::octree() gives it; `kept` null: nothing is kept.
    FrameOctreeGpu(KeptVoxels* kept, const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces, Stats& stats);

    SparseVoxelOctreeGpu* operator->() const { return tree_.get(); }
    SparseVoxelOctreeGpu* get() const { return tree_.get(); }  // null: none
    explicit operator bool() const { return tree_ != nullptr; }
    /// To be asked once the first pass is done, and may be after each: SparseVoxelOctreeGpu::settle(). Once it is whole
    /// its voxels are counted.
    bool settle(Stats& stats);

private:
    std::shared_ptr<SparseVoxelOctreeGpu> tree_;
    bool counted_ = false;
};

}  // namespace photond

#include "renderer/voxels/kept_voxels.h"

#include <algorithm>
#include <utility>

#include "renderer/scene/pose.h"

namespace photond {

namespace {

constexpr uint64_t kKeptDivisor = 8;  // of the budget's rest: what is kept at most

std::vector<bool> find_voxelised(const Scene& scene) {
    std::vector<bool> voxelised;
    voxelised.reserve(scene.instances.size());
    for (const Instance& instance : scene.instances)
        voxelised.push_back(is_voxelised(scene.materials[scene.meshes[instance.mesh].material]));
    return voxelised;
}

}  // namespace

void KeptVoxels::note(const SceneChange& change) {
    if (!parts_) return;
    moved_meshes_.insert(moved_meshes_.end(), change.moved.begin(), change.moved.end());
    moved_meshes_.insert(moved_meshes_.end(), change.reshaped.begin(), change.reshaped.end());
    // Each once: many frames may go by before the next octree.
    std::sort(moved_meshes_.begin(), moved_meshes_.end());
    moved_meshes_.erase(std::unique(moved_meshes_.begin(), moved_meshes_.end()), moved_meshes_.end());
}

bool KeptVoxels::holds(const VoxelGrid& grid, bool surfaces) const {
    if (!parts_) return false;
    const VoxelGrid& kept = parts_->grid();
    return kept.low == grid.low && kept.cell_m == grid.cell_m && kept.resolution == grid.resolution &&
           parts_->has_surfaces() == surfaces;
}

std::vector<uint32_t> KeptVoxels::changed_instances(const Scene& scene) const {
    const std::vector<bool> voxelised = find_voxelised(scene);
    std::vector<bool> moved(scene.meshes.size());
    for (const uint32_t mesh : moved_meshes_) moved[mesh] = true;
    std::vector<uint32_t> changed;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        if (voxelised[i] != voxelised_[i] || (voxelised[i] && moved[scene.instances[i].mesh])) changed.push_back(i);
    return changed;
}

SparseVoxelOctree KeptVoxels::octree(const Scene& scene, const VoxelGrid& grid, bool surfaces, MemoryBudget& budget,
                                     Stats& stats) {
    const bool follows = holds(grid, surfaces);
    const StageTimer timer(stats, follows ? "svo_update" : "svo_build");
    if (!follows) clear();
    // Where memory runs out halfway, nothing is kept.
    std::optional<InstanceBricks> parts = std::exchange(parts_, std::nullopt);
    if (follows)
        parts->update(scene, changed_instances(scene));
    else
        parts.emplace(scene, grid, surfaces);
    SparseVoxelOctree tree(scene, *parts);
    moved_meshes_.clear();
    const uint64_t accounted = budget.accounted_bytes() + tree.bytes();
    const uint64_t rest = budget.limit_bytes() - std::min(budget.limit_bytes(), accounted);
    if (scene.rig && parts->bytes() <= rest / kKeptDivisor) {
        voxelised_ = find_voxelised(scene);
        parts_ = std::move(parts);
    }
    return tree;
}

uint64_t KeptVoxels::bytes() const { return parts_ ? parts_->bytes() : 0; }

void KeptVoxels::clear() {
    parts_.reset();
    moved_meshes_ = {};
}

SparseVoxelOctree make_octree(KeptVoxels* kept, const Scene& scene, const VoxelGrid& grid, bool surfaces,
                              MemoryBudget& budget, Stats& stats) {
    constexpr const char* kTree = "sparse_voxel_octree";
    budget.require(kTree, SparseVoxelOctree::estimate(scene, grid, surfaces).peak_bytes);
    KeptVoxels nothing;
    SparseVoxelOctree tree = (kept ? *kept : nothing).octree(scene, grid, surfaces, budget, stats);
    budget.record(kTree, tree.bytes());
    if (kept && kept->bytes() > 0) budget.record("kept_voxels", kept->bytes());
    return tree;
}

}  // namespace photond

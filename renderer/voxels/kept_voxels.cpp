#include "renderer/voxels/kept_voxels.h"

#include <algorithm>
#include <utility>

#include "renderer/scene/scene.h"
#include "renderer/voxels/kept_voxels_gpu.h"

namespace photond {

namespace {

constexpr uint64_t kKeptDivisor = 8;  // of the budget's rest: what is kept at most

}  // namespace

KeptVoxels::KeptVoxels() = default;
KeptVoxels::~KeptVoxels() = default;

void KeptVoxels::note(const SceneChange& change) {
    if (parts_) moved_.note(change);
    if (on_device_) on_device_->note(change);
}

bool KeptVoxels::holds(const VoxelGrid& grid, bool surfaces) const {
    return parts_ && same_grid(parts_->grid(), grid) && parts_->has_surfaces() == surfaces;
}

bool KeptVoxels::may_keep(uint64_t bytes, uint64_t rest_bytes) { return bytes <= rest_bytes / kKeptDivisor; }

KeptVoxelsGpu& KeptVoxels::on_device() {
    if (!on_device_) on_device_ = std::make_unique<KeptVoxelsGpu>();
    return *on_device_;
}

std::map<std::string, uint64_t> KeptVoxels::device_structures() const {
    return on_device_ ? on_device_->structures() : std::map<std::string, uint64_t>{};
}

SparseVoxelOctree KeptVoxels::octree(const Scene& scene, const VoxelGrid& grid, bool surfaces, MemoryBudget& budget,
                                     Stats& stats) {
    const bool follows = holds(grid, surfaces);
    const StageTimer timer(stats, follows ? "svo_update" : "svo_build");
    if (!follows) parts_.reset();
    // Where memory runs out halfway, nothing is kept.
    std::optional<InstanceBricks> parts = std::exchange(parts_, std::nullopt);
    if (follows)
        parts->update(scene, moved_.list(scene));
    else
        parts.emplace(scene, grid, surfaces);
    SparseVoxelOctree tree(scene, *parts);
    moved_.settle(scene);
    const uint64_t accounted = budget.accounted_bytes() + tree.bytes();
    const uint64_t rest = budget.limit_bytes() - std::min(budget.limit_bytes(), accounted);
    if (scene.rig && may_keep(parts->bytes(), rest)) parts_ = std::move(parts);
    return tree;
}

uint64_t KeptVoxels::bytes() const { return parts_ ? parts_->bytes() : 0; }

void KeptVoxels::clear() {
    parts_.reset();
    on_device_.reset();
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

#include "renderer/voxels/kept_voxels_gpu.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/voxels/kept_voxels.h"

namespace photond {

namespace {

uint64_t triangles_of(const Scene& scene, std::span<const uint32_t> instances) {
    uint64_t triangles = 0;
    for (const uint32_t i : instances) triangles += scene.meshes[scene.instances[i].mesh].triangles.size();
    return triangles;
}

/// Those of rising numbers that are not among others of rising numbers.
std::vector<uint32_t> without(std::span<const uint32_t> numbers, std::span<const uint32_t> others) {
    std::vector<uint32_t> left;
    std::ranges::set_difference(numbers, others, std::back_inserter(left));
    return left;
}

std::vector<uint32_t> all_but(const Scene& scene, std::span<const uint32_t> instances) {
    std::vector<uint32_t> all(scene.instances.size());
    std::iota(all.begin(), all.end(), 0u);
    return without(all, instances);
}

/// Whether so much may be kept beside what is kept, which is in use.
bool is_room_for(gpu::Device& device, uint64_t more_bytes, uint64_t kept_bytes) {
    const uint64_t limit = device.memory_limit_bytes(), used = device.memory().used_bytes() + more_bytes;
    return KeptVoxels::may_keep(kept_bytes + more_bytes, limit - std::min(limit, used));
}

}  // namespace

void KeptVoxelsGpu::note(const SceneChange& change) {
    if (tree_) moved_.note(change);
}

void KeptVoxelsGpu::follow(SparseVoxelOctreeGpu& tree, const Scene& scene, Stats& stats) {
    tree.settle(stats);  // where the last frame was left before it was
    if (std::exchange(came_to_rest_, false)) tree.keep_nothing();
    const std::vector<uint32_t> moved = moved_.list(scene);
    if (moved.empty()) return;
    const std::vector<uint32_t> fresh = without(moved, moving_);
    const auto half = static_cast<std::ptrdiff_t>(moving_.size());
    moving_.insert(moving_.end(), fresh.begin(), fresh.end());
    std::inplace_merge(moving_.begin(), moving_.begin() + half, moving_.end());

    const std::vector<uint32_t> still = all_but(scene, moving_);
    const uint64_t still_triangles = triangles_of(scene, still);
    const bool pays = fresh.empty() && 2 * still_triangles >= scene.triangle_count;
    if (!pays) tree.keep_nothing();
    if (pays && !tree.keeps() && is_room_for(tree.device(), tree.most_kept_bytes(), tree.device_bytes_with_scratch()))
        tree.keep(still, stats);
    if (tree.keeps())
        tree.start_update(moving_);
    else
        tree.start_rebuild();

    resting_triangles_ += triangles_of(scene, without(moving_, moved));
    if (resting_triangles_ < still_triangles) return;
    moving_ = moved;
    resting_triangles_ = 0;
    came_to_rest_ = true;
}

std::shared_ptr<SparseVoxelOctreeGpu> KeptVoxelsGpu::octree(const gpu::DeviceScene& device_scene, const VoxelGrid& grid,
                                                            bool surfaces, Stats& stats) {
    const Scene& scene = device_scene.scene();
    // Where memory runs out halfway, nothing is kept.
    std::shared_ptr<SparseVoxelOctreeGpu> tree = std::exchange(tree_, nullptr);
    if (tree && tree->is_of(device_scene, grid, surfaces)) {
        follow(*tree, scene, stats);
    } else {
        clear();
        tree.reset();  // not both at once
        tree = std::make_shared<SparseVoxelOctreeGpu>(device_scene, grid, surfaces);
        tree->build_now(stats, scene.rig != nullptr);
    }
    moved_.settle(scene);
    if (scene.rig && is_room_for(tree->device(), 0, tree->device_bytes_with_scratch())) tree_ = tree;
    return tree;
}

std::map<std::string, uint64_t> KeptVoxelsGpu::structures() const {
    return tree_ ? tree_->structures() : std::map<std::string, uint64_t>{};
}

void KeptVoxelsGpu::clear() {
    tree_.reset();
    moving_.clear();
    resting_triangles_ = 0;
    came_to_rest_ = false;
}

FrameOctreeGpu::FrameOctreeGpu(KeptVoxels* kept, const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces,
                               Stats& stats) {
    KeptVoxelsGpu nothing;
    tree_ = (kept ? kept->on_device() : nothing).octree(scene, grid, surfaces, stats);
}

FrameOctreeGpu& FrameOctreeGpu::operator=(FrameOctreeGpu&& other) noexcept {
    std::swap(tree_, other.tree_);
    std::swap(counted_, other.counted_);
    return *this;
}

FrameOctreeGpu::~FrameOctreeGpu() {
    if (!tree_) return;
    try {
        tree_->device().wait_idle();
    } catch (const gpu::DeviceLost&) {  // which has dropped the work
    }
}

bool FrameOctreeGpu::settle(Stats& stats) {
    if (!tree_) return false;
    const bool was_short = tree_->settle(stats);
    if (!counted_) stats.counts.voxels += tree_->voxel_count();
    counted_ = true;
    return was_short;
}

}  // namespace photond

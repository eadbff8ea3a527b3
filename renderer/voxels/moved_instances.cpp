#include "renderer/voxels/moved_instances.h"

#include <algorithm>

#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/voxels/voxel_grid.h"

namespace photond {

namespace {

std::vector<bool> find_voxelised(const Scene& scene) {
    std::vector<bool> voxelised;
    voxelised.reserve(scene.instances.size());
    for (const Instance& instance : scene.instances)
        voxelised.push_back(is_voxelised(scene.materials[scene.meshes[instance.mesh].material]));
    return voxelised;
}

}  // namespace

void MovedInstances::note(const SceneChange& change) {
    moved_meshes_.insert(moved_meshes_.end(), change.moved.begin(), change.moved.end());
    moved_meshes_.insert(moved_meshes_.end(), change.reshaped.begin(), change.reshaped.end());
    // Each once: many frames may go by before anybody asks.
    std::sort(moved_meshes_.begin(), moved_meshes_.end());
    moved_meshes_.erase(std::unique(moved_meshes_.begin(), moved_meshes_.end()), moved_meshes_.end());
}

std::vector<uint32_t> MovedInstances::list(const Scene& scene) const {
    const std::vector<bool> voxelised = find_voxelised(scene);
    std::vector<bool> moved(scene.meshes.size());
    for (const uint32_t mesh : moved_meshes_) moved[mesh] = true;
    std::vector<uint32_t> changed;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        if (voxelised[i] != voxelised_[i] || (voxelised[i] && moved[scene.instances[i].mesh])) changed.push_back(i);
    return changed;
}

void MovedInstances::settle(const Scene& scene) {
    voxelised_ = find_voxelised(scene);
    moved_meshes_.clear();
}

}  // namespace photond

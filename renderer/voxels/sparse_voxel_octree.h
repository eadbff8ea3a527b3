#pragma once
// The sparse voxel octree of a scene, on the CPU [Sun 2015, 3.1 and 4.3.2]; beyond the thesis: conservative voxels,
// bricks of 4x4x4 of them as one mask at the leaves, and a triangle for each.
//
// Twin: SparseVoxelOctreeGpu, whose arrays are the same bit for bit.

#include <optional>
#include <vector>

#include "renderer/voxels/instance_bricks.h"
#include "renderer/voxels/svo_march.h"
#include "renderer/voxels/voxel_grid.h"

namespace photond {

class SparseVoxelOctree {
public:
    /// Of a finished scene, which is not needed any more. `surfaces`: each set voxel knows the triangle of least number
    /// among those that touch it. The same arrays however many threads build them.
    SparseVoxelOctree(const Scene& scene, const VoxelGrid& grid, bool surfaces)
        : SparseVoxelOctree(scene, InstanceBricks(scene, grid, surfaces)) {}
    /// The same of what the scene's instances have in the grid's bricks.
    SparseVoxelOctree(const Scene& scene, const InstanceBricks& parts);
    /// What a tree will have, by its triangles' sizes alone. Most are right to a factor of two; where triangles lie
    /// many in a brick, as in foliage, it is less than said.
    struct Estimate {
        uint64_t fragments, bricks, nodes, voxels;
        uint64_t bytes;       // of the tree
        uint64_t part_bytes;  // of what the instances have in its bricks
        uint64_t peak_bytes;  // while it is built, on the CPU
    };
    static Estimate estimate(const Scene& scene, const VoxelGrid& grid, bool surfaces);
    static uint64_t estimate_bytes(const Scene& scene, const VoxelGrid& grid, bool surfaces) {
        return estimate(scene, grid, surfaces).bytes;
    }

    SvoView view() const { return {constants_, nodes_, bricks_, surfaces_, &*cells_}; }
    const gpu::SvoConstants& constants() const { return constants_; }
    /// Where each instance's triangles begin among the numbers in view().surfaces.
    std::span<const uint32_t> first_triangles() const { return first_triangles_; }
    uint64_t voxel_count() const { return voxel_count_; }
    uint64_t bytes() const;

private:
    gpu::SvoConstants constants_;
    std::vector<gpu::SvoNode> nodes_;
    std::vector<gpu::SvoBrick> bricks_;
    std::vector<uint32_t> surfaces_;
    std::vector<uint32_t> first_triangles_;
    std::optional<SvoCells> cells_;
    uint64_t voxel_count_ = 0;
};

}  // namespace photond

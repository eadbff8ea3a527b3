#pragma once
// What each instance of a scene has in each brick of a grid: what an octree is put together from, and what of it stays
// where little moves.
//
// Of several triangles in a voxel the tree wants the one of least number, whoever it belongs to: a least of leasts, so
// that instances can be voxelised apart and in any order, and the tree has the same bits.

#include <span>
#include <vector>

#include "renderer/voxels/voxel_grid.h"

namespace photond {

/// An instance's voxels in one brick.
struct InstanceBrick {
    uint32_t brick;  // Morton code: the children's numbers from the root down
    uint32_t instance;
    uint64_t mask;
    uint64_t first_triangle;  // where its voxels' triangles begin
};

class InstanceBricks {
public:
    /// Of a scene as it is now. `surfaces`: with triangles.
    InstanceBricks(const Scene& scene, const VoxelGrid& grid, bool surfaces);

    /// Voxelises these instances again, rising numbers, as they are now. Other instances are as they were, and there
    /// are as many.
    void update(const Scene& scene, std::span<const uint32_t> instances);

    const VoxelGrid& grid() const { return constants_.grid; }
    bool has_surfaces() const { return surfaces_; }
    /// In the order of (brick, instance).
    std::span<const InstanceBrick> bricks() const { return bricks_; }
    /// One a set voxel, in the order of the mask's bits: the least of the instance's mesh that touches it.
    const uint32_t* triangles_of(const InstanceBrick& brick) const { return triangles_.data() + brick.first_triangle; }
    uint64_t bytes() const;

    /// While they are made anew: of so many triangles and pieces of them in bricks.
    static uint64_t scratch_bytes(uint64_t triangles, uint64_t fragments);

private:
    struct Fragment;
    std::vector<Fragment> make_fragments(const Scene& scene, std::span<const uint32_t> instances,
                                         std::span<const uint32_t> first) const;

    gpu::SvoConstants constants_;
    bool surfaces_;
    std::vector<InstanceBrick> bricks_;
    std::vector<uint32_t> triangles_;
};

}  // namespace photond

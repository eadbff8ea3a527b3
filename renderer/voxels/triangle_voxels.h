#pragma once
// Which voxels a triangle touches, exactly: separating axes in whole numbers.
//
// A voxel counts as touched where its box, widened by one sub-unit to all sides, meets the rounded triangle, borders
// included. Rounding moves a corner by less than that (voxel_grid.h), so every voxel that the triangle itself touches
// is among them, and no voxel further from it than 2 sub-units. Points, segments and slivers are triangles like others.
// GLSL twin: triangle_voxels.glsl.
//
// [Schwarz and Seidel 2010] Fast Parallel Surface and Solid Voxelization on GPUs. ACM TOG 29(6). Departure: intervals
// instead of one-sided edge functions, which a triangle seen on edge has none of.

#include "renderer/voxels/voxel_grid.h"

namespace photond {

/// Half-open range of whole numbers.
struct BrickRange {
    int32_t begin = 0, end = 0;
    bool empty() const { return begin >= end; }
};

/// A triangle ready to be asked about boxes.
class TriangleVoxels {
public:
    /// `bricks`: of the grid, along an edge; none outside of it is given.
    TriangleVoxels(const QuantisedTriangle& triangle, int32_t bricks);

    /// Bricks are visited by columns: along the axis that the triangle is closest to being at right angles to, which
    /// leaves few bricks in each.
    uint32_t columns() const { return static_cast<uint32_t>(columns_[0] * columns_[1]); }
    /// Brick coordinates of a column's bricks that may be touched: `brick` with component axis() in `along`.
    BrickRange column(uint32_t index, glm::ivec3& brick) const;
    int axis() const { return axis_; }

    /// Bit x + 4 y + 16 z for each touched voxel of a brick.
    uint64_t brick_mask(const glm::ivec3& brick) const;

private:
    /// A line in the plane of two axes: through an edge, and how far the triangle reaches along its normal.
    struct Edge {
        int64_t normal[2];
        int64_t low, high;
    };

    glm::ivec3 low_, high_;           // the triangle's box
    int64_t normal_[3];               // 0 where it has none
    int64_t plane_low_, plane_high_;  // of normal . p over all corners of a touched box, less its least corner's
    std::array<Edge, 9> edges_;       // of the planes xy, yz, zx
    glm::ivec3 first_brick_, end_brick_;
    int axis_ = 0;
    int32_t columns_[2] = {0, 0};  // along axis_ + 1 and axis_ + 2
};

}  // namespace photond

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

#include <algorithm>

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
    uint32_t columns() const { return static_cast<uint32_t>(along(1) * along(2)); }
    /// Those of a column's bricks that may be touched: of coordinates `brick`, the component axis() being replaced by
    /// those of the range.
    BrickRange column(uint32_t index, glm::ivec3& brick) const;
    int axis() const { return axis_; }

    /// Bit x + 4 y + 16 z for each touched voxel of a brick.
    uint64_t brick_mask(const glm::ivec3& brick) const;

private:
    int32_t along(int step) const {  // of its bricks, along axis_ + step
        const int axis = (axis_ + step) % 3;
        return std::max(end_brick_[axis] - first_brick_[axis], 0);
    }
    /// Whether the triangle's shadow in the plane of axes u and v may meet a square; false is exact.
    bool square_may_touch(int u, int v, const glm::ivec2& low, int32_t side) const;
    /// Bit i + 4 j for each square of the brick's, seen along an axis, that the triangle's shadow may meet.
    uint32_t square_mask(int u, int v, const glm::ivec3& brick) const;

    std::array<glm::ivec3, 3> p_;
    glm::ivec3 low_, high_;               // the triangle's box
    std::array<int64_t, 3> normal_{};     // 0 where it has none
    int64_t offset_ = 0;                  // normal . p on the triangle
    glm::ivec3 first_brick_, end_brick_;  // that its box touches
    int axis_ = 0;
};

}  // namespace photond

#pragma once
// All points within a fixed radius: a grid of cells with the points sorted by cell.
//
// Cells along x follow one another in the table, so that the cells a search touches in one row of the grid hold one
// run of points, contiguous in memory, which is gone through with vector instructions. The table has about as many
// entries as there are points: where the grid's box has no more cells than that, each cell has its own entry; else rows
// begin at hashed places, and rows that meet there only cost the distance tests of each other's points.

#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/photons/neighbours.h"
#include "renderer/photons/point_bucket.h"

namespace photond {

class HashGrid {
public:
    HashGrid() = default;
    /// For searches of at most `radius_m` > 0. Builds in parallel; the grid is the same for any number of threads.
    /// `order`, as long as `points`, is set so that the grid's point i is points[order[i]]. Any extent of the points
    /// against the radius is allowed (cells are hashed), and any number of points in one cell. All coordinates finite;
    /// at most 2^31 points.
    HashGrid(std::span<const vec3> points, float radius_m, std::span<uint32_t> order);

    size_t size() const { return size_; }
    float radius_m() const { return radius_m_; }
    vec3 position(uint32_t index) const { return {x_[index], y_[index], z_[index]}; }

    /// All points strictly nearer to p than `radius_m` (at most that of the grid), each once.
    void find_within(const vec3& p, float radius_m, Neighbours& out) const;

    /// Appends the indices of points that may be nearer than `radius_m` (at most that of the grid) to some place of the
    /// box, in ascending order: all that are, and hardly any other.
    void find_near_box(const Bounds3& box, float radius_m, std::vector<uint32_t>& out) const;

    /// The squared distance [m^2] as searches round it: q is found when it is below radius_m * radius_m.
    static float distance_sq_m2(const vec3& p, const vec3& q) { return length_sq(q.x - p.x, q.y - p.y, q.z - p.z); }

    uint64_t bytes() const;
    /// The most bytes() that so many points can come to, wherever they lie.
    static uint64_t bytes_for(uint64_t points);
    /// Bytes taken besides, while a grid is built.
    static uint64_t build_bytes_for(uint64_t points);

private:
    /// Cells of a query or of the grid along each axis, or a cell.
    using Cells = glm::ivec3;
    /// Points of the grid's order, [begin, end).
    struct Run {
        uint32_t begin, end;
    };

    void lay_out(std::span<const vec3> points);
    void sort(std::span<const vec3> points, std::span<uint32_t> order);
    Cells cell_of(const vec3& p) const;
    template <class Add>
    void visit_runs(const Cells& low, const Cells& high, const Add& add) const;
    static void take_doubles_out(std::span<Run> runs);
    /// Where the row of cells (y, z) begins in the table; hashed: to be taken modulo its size.
    uint32_t row(int32_t y, int32_t z) const;
    uint32_t slot_of(const vec3& p) const;

    uint32_t size_ = 0;
    float radius_m_ = 0;
    vec3 origin_{0};
    vec3 cells_per_m_{0};
    Cells cells_{0};
    bool hashed_ = false;
    uint32_t slots_ = 0;            // a power of two when hashed
    std::vector<uint32_t> start_;   // of each slot's points, and their end
    std::vector<float> x_, y_, z_;  // in the grid's order, and a vector's length beyond
};

}  // namespace photond

#pragma once
// All points within a fixed radius: a grid of cells, hashed, with the points sorted by cell.

#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/photons/neighbours.h"

namespace photond {

class HashGrid {
public:
    HashGrid() = default;
    /// For searches of at most `radius_m` > 0. Builds in parallel; the grid is the same for any number of threads.
    /// `order`, as long as `points`, is set so that the grid's point i is points[order[i]]. Any extent of the points
    /// against the radius is allowed (cells are hashed), and any number of points in one cell. All coordinates finite.
    HashGrid(std::span<const vec3> points, float radius_m, std::span<uint32_t> order);

    size_t size() const { return x_.size(); }
    float radius_m() const { return radius_m_; }

    /// All points strictly nearer to p than `radius_m` (at most that of the grid), each once.
    void find_within(const vec3& p, float radius_m, Neighbours& out) const;

    uint64_t bytes() const;
    static uint64_t bytes_for(uint64_t points);

private:
    float radius_m_ = 0;
    std::vector<float> x_, y_, z_;  // in the grid's order
};

}  // namespace photond

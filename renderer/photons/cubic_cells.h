#pragma once
// An endless grid of cubes, and the cells of it that a straight piece of an edge comes near.

#include <algorithm>
#include <cstdint>

#include "renderer/core/geometry.h"
#include "renderer/core/rng.h"

namespace photond {

/// Cells are named by whole numbers, in floats.
struct CubicCells {
    vec3 origin{0};
    float per_m = 0;  // cells [1/m]

    vec3 cell_of(const vec3& p) const { return glm::floor((p - origin) * per_m); }

    /// One to one for cells less than 2^20 from the origin.
    static uint64_t key(const vec3& cell) {
        constexpr uint64_t kMask = (1 << 21) - 1;
        const auto bits = [](float x) { return static_cast<uint64_t>(static_cast<int64_t>(x)) & kMask; };
        return bits(cell.x) | bits(cell.y) << 21 | bits(cell.z) << 42;
    }
    static uint64_t hash(const vec3& cell) { return hash64(key(cell)); }

    /// Calls visit(cell), once each, for cells among which are all those within `reach_m` of the line from a to b.
    /// Walks along its major axis, one layer of cells at a time.
    template <class Visit>
    void for_cells_within(const vec3& from, const vec3& to, float reach_m, const Visit& visit) const {
        const float reach = 1.0001f * reach_m * per_m + 1e-3f;  // in cells; more than rounding can take away
        const vec3 a = (from - origin) * per_m, d = (to - origin) * per_m - a, size = glm::abs(d);
        const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto first = static_cast<int64_t>(std::floor(std::min(a[axis], a[axis] + d[axis]) - reach));
        const auto last = static_cast<int64_t>(std::floor(std::max(a[axis], a[axis] + d[axis]) + reach));
        for (int64_t number = first; number <= last; ++number) {
            const auto layer = static_cast<float>(number);
            // The part of the edge that is within reach of the layer.
            float t0 = 0, t1 = 1;
            if (size[axis] > 0) {
                const float enter = (layer - reach - a[axis]) / d[axis],
                            leave = (layer + 1 + reach - a[axis]) / d[axis];
                t0 = std::clamp(std::min(enter, leave), 0.0f, 1.0f),
                t1 = std::clamp(std::max(enter, leave), 0.0f, 1.0f);
            }
            const vec3 p = a + t0 * d, q = a + t1 * d;
            const vec3 low = glm::floor(glm::min(p, q) - reach), high = glm::floor(glm::max(p, q) + reach);
            vec3 cell;
            cell[axis] = layer;
            for (cell[u] = low[u]; cell[u] <= high[u]; ++cell[u]) {
                for (cell[v] = low[v]; cell[v] <= high[v]; ++cell[v]) visit(cell);
            }
        }
    }
};

}  // namespace photond

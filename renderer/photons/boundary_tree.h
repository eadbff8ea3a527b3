#pragma once
// Boundary edges that reach into a disc: a table of occupied cells, which most points leave after one look, and a tree
// of boxes for the others. Discs are flat: of a finely cut body most edges lie beside the slab, and whole subtrees with
// them.

#include <array>
#include <bit>

#include "renderer/core/lanes.h"
#include "renderer/core/rng.h"
#include "renderer/photons/boundary_edges.h"

namespace photond {

class BoundaryTree {
public:
    /// For discs of at most `radius_m`. The same tree for any number of threads.
    BoundaryTree(std::vector<BoundaryEdge> edges, float radius_m);

    /// False: no edge within the radius of p. True: perhaps one.
    bool may_have_edges(const vec3& p) const {
        if (edges_.empty()) return false;
        const uint64_t bit = hash_cell(glm::floor((p - origin_) * per_cell_)) >> bit_shift_;
        return occupied_[bit / 64] >> (bit % 64) & 1;
    }

    /// Calls visit(edge) for every edge with a point within `radius_m` of p and `thickness_m` of the plane through p,
    /// and for some others.
    template <class Visit>
    void visit_edges(const vec3& p, const vec3& normal, float radius_m, float thickness_m, const Visit& visit) const;

    size_t size() const { return edges_.size(); }
    uint64_t bytes() const {
        return edges_.size() * sizeof(BoundaryEdge) + nodes_.size() * sizeof(Node) +
               occupied_.size() * sizeof(uint64_t);
    }

private:
    static constexpr size_t kWidth = 8, kWidthBits = 3;  // children of a node; edges of a leaf, at most
    static_assert(kWidth == kLanes);
    /// The boxes of a node's children: centres and half sizes, by axis. Plain floats, as threads fill them side by
    /// side.
    struct alignas(32) Node {
        std::array<std::array<float, kWidth>, 3> centre;
        std::array<std::array<float, kWidth>, 3> half;  // minus infinity where there is no child
    };
    static Vec3Lanes load(const std::array<std::array<float, kWidth>, 3>& v) {
        const auto lanes = [](const auto& x) { return FloatLanes(x.data(), std::experimental::element_aligned); };
        return {lanes(v[0]), lanes(v[1]), lanes(v[2])};
    }

    // All ways down are equally long. The k-th of 2^level equal parts of the edges:
    size_t first_edge(size_t level, size_t k) const { return k * edges_.size() >> level; }
    // The k-th node of level kWidthBits `depth`; nodes stand level by level.
    static size_t node_index(size_t depth, size_t k) {
        return ((size_t{1} << kWidthBits * depth) - 1) / (kWidth - 1) + k;
    }
    void split(size_t level, size_t k);
    void fill_cells(float radius_m);
    template <class Visit>
    void for_cells_within(const BoundaryEdge& e, float radius_m, const Visit& visit) const;

    static uint64_t hash_cell(const vec3& cell) {
        constexpr uint64_t kMask = (1 << 21) - 1;
        const auto bits = [](float x) { return static_cast<uint64_t>(static_cast<int64_t>(x)) & kMask; };
        return hash64(bits(cell.x) | bits(cell.y) << 21 | bits(cell.z) << 42);
    }

    std::vector<BoundaryEdge> edges_;
    size_t depth_ = 1;  // of the leaves
    std::vector<Node> nodes_;
    vec3 origin_{0};
    float per_cell_ = 0;  // [1/m]
    int bit_shift_ = 0;
    std::vector<uint64_t> occupied_;  // one bit for the cells of each hash
};

template <class Visit>
void BoundaryTree::visit_edges(const vec3& p, const vec3& normal, float radius_m, float thickness_m,
                               const Visit& visit) const {
    if (edges_.empty()) return;
    const vec3 slope = glm::abs(normal);
    struct Waiting {
        uint32_t depth, k;
    };
    std::array<Waiting, (kWidth - 1) * 11 + 1> stack;  // 8^11 leaves are more than any memory holds
    size_t waiting = 1;
    stack[0] = {0, 0};
    while (waiting > 0) {
        const Waiting at = stack[--waiting];
        const Node& node = nodes_[node_index(at.depth, at.k)];
        const Vec3Lanes to = load(node.centre) - broadcast(p), half = load(node.half);
        const FloatLanes zero = 0;
        const FloatLanes x = max(abs(to.x) - half.x, zero), y = max(abs(to.y) - half.y, zero),
                         z = max(abs(to.z) - half.z, zero);
        const FloatMask reached = x * x + y * y + z * z <= sqr(radius_m) &&
                                  abs(dot(to, broadcast(normal))) <= thickness_m + dot(broadcast(slope), half);
        if (none_of(reached)) continue;
        for (uint32_t i = 0; i < kWidth; ++i) {
            if (!reached[i]) continue;
            const uint32_t child = at.k * uint32_t{kWidth} + i;
            if (at.depth + 1 < depth_) {
                stack[waiting++] = {at.depth + 1, child};
                continue;
            }
            const size_t end = first_edge(kWidthBits * depth_, child + 1);
            for (size_t e = first_edge(kWidthBits * depth_, child); e < end; ++e) visit(edges_[e]);
        }
    }
}

}  // namespace photond

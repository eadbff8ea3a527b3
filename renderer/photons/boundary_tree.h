#pragma once
// Boundary edges that reach into a disc: a table of occupied cells, which most points leave after one look, and a tree
// of boxes for the others. Discs are flat: of a finely cut body most edges lie beside the slab, and whole subtrees with
// them.

#include <array>
#include <bit>

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
        return edges_.size() * sizeof(BoundaryEdge) + nodes_.size() * sizeof(Box) + occupied_.size() * sizeof(uint64_t);
    }

private:
    static constexpr size_t kBlock = 4;  // edges of a leaf, at most
    struct Box {
        vec3 centre{0};
        vec3 half{-1};
    };

    // Edges stand in blocks. Node k of level l, at (1 << l) + k in the heap, holds the blocks from k n >> l on.
    size_t first_block(size_t level, size_t k) const { return k * blocks_ >> level; }
    size_t first_edge(size_t level, size_t k) const { return std::min(edges_.size(), first_block(level, k) * kBlock); }
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
    size_t blocks_ = 0, levels_ = 0;  // leaves are on level `levels_`
    std::vector<Box> nodes_;          // a heap from 1 on
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
    std::array<uint32_t, 64> stack;
    size_t waiting = 1;
    stack[0] = 1;
    while (waiting > 0) {
        const uint32_t node = stack[--waiting];
        const Box& box = nodes_[node];
        const vec3 to = box.centre - p, apart = glm::max(glm::abs(to) - box.half, vec3(0));
        if (glm::dot(apart, apart) > sqr(radius_m)) continue;
        if (std::fabs(glm::dot(to, normal)) > thickness_m + glm::dot(slope, box.half)) continue;
        const size_t level = static_cast<size_t>(std::bit_width(node)) - 1, k = node - (size_t{1} << level);
        if (level < levels_) {
            stack[waiting++] = 2 * node;
            stack[waiting++] = 2 * node + 1;
            continue;
        }
        const size_t end = first_edge(level, k + 1);
        for (size_t i = first_edge(level, k); i < end; ++i) visit(edges_[i]);
    }
}

}  // namespace photond

#pragma once
// Boundary edges that reach into a disc: a table of occupied cells, which most points leave after one look, and a tree
// of boxes for the others. Discs are flat: of a finely cut body most edges lie beside the slab, and whole subtrees with
// them. And most edges are bends of smooth surfaces, which bound a surface only as seen along few normals: the tree is
// one of places and normals, as those for finding the contours of bodies are. [Sander et al. 2000]
//
// [Sander et al. 2000] Silhouette Clipping. SIGGRAPH.

#include <array>
#include <bit>

#include "renderer/core/lanes.h"
#include "renderer/photons/boundary_edges.h"
#include "renderer/photons/cubic_cells.h"

namespace photond {

/// Edges between triangles of which one, turned to the side of the query's normal or away from it, makes at most 60
/// degrees with it: normals of the disc test.
inline constexpr float kSameSurface = 0.5f;

/// Three floats each of kLanes things. Plain arrays, as threads fill them side by side.
struct Vec3Block {
    std::array<std::array<float, kLanes>, 3> axis{};

    void set(size_t lane, const vec3& v) { axis[0][lane] = v.x, axis[1][lane] = v.y, axis[2][lane] = v.z; }
    Vec3Lanes load() const {
        const auto lanes = [](const auto& x) { return FloatLanes(x.data(), std::experimental::vector_aligned); };
        return {lanes(axis[0]), lanes(axis[1]), lanes(axis[2])};
    }
};

/// kLanes of the edges. Normals are zero where there is none.
struct alignas(sizeof(FloatLanes)) EdgeBlock {
    Vec3Block a, ab, normal, other_normal;  // ab: from a to b
    std::array<float, kLanes> continues_at_m{};
};

class BoundaryTree {
public:
    /// For discs of at most `radius_m`. The same tree for any number of threads.
    BoundaryTree(std::vector<BoundaryEdge> edges, float radius_m);

    /// False: no edge within the radius of p. True: perhaps one.
    bool may_have_edges(const vec3& p) const {
        if (size_ == 0) return false;
        const uint64_t bit = CubicCells::hash(cells_.cell_of(p)) >> bit_shift_;
        return occupied_[bit / 64] >> (bit % 64) & 1;
    }

    /// Of the blocks that a look-up visits: of 32, 64 and 128 about the fastest in heaps and in a furnished room.
    enum class Limit : uint8_t { None, Limited };
    static constexpr size_t kMostBlocks = 64;
    /// Calls visit(block) for blocks that hold every edge with a point within `radius_m` of p and `thickness_m` of the
    /// plane through p, one of whose normals (or the zero of a half-edge) is within the cone of kSameSurface about
    /// `normal`, or about its opposite, and the other is not. Most of what a block holds beside is not such. With
    /// `limit` Limited, when there are more than kMostBlocks of them, none is visited: then the answer is false.
    template <class Visit>
    bool visit_blocks(const vec3& p, const vec3& normal, float radius_m, float thickness_m, Limit limit,
                      const Visit& visit) const;

    size_t size() const { return size_; }
    uint64_t bytes() const {
        return blocks_.size() * sizeof(EdgeBlock) + nodes_.size() * sizeof(Node) + occupied_.size() * sizeof(uint64_t);
    }

private:
    static constexpr size_t kWidth = kLanes;  // children of a node; edges of a leaf
    static constexpr size_t kWidthBits = std::countr_zero(kWidth);
    static constexpr size_t kMostDepth = 16;
    /// The boxes of a node's children: of their edges, and of both normals of each.
    struct alignas(sizeof(FloatLanes)) Node {
        Vec3Block centre, half;  // half sizes; minus infinity where there is no child
        Vec3Block normal_centre, normal_half;
    };

    // All ways down are equally long; nodes and leaves are full, but for the last of each level. Of level 0 the one
    // part is all edges, of level kWidthBits depth_ a part is a leaf.
    size_t part_size(size_t level) const { return kWidth << (kWidthBits * depth_ - level); }
    size_t parts(size_t level) const { return (size_ + part_size(level) - 1) / part_size(level); }
    void split(std::vector<BoundaryEdge>& edges, size_t level, size_t k, float radius_m);
    void bound_child(const std::vector<BoundaryEdge>& edges, size_t depth, size_t k);
    void fill_block(const std::vector<BoundaryEdge>& edges, size_t k);
    void fill_cells(const std::vector<BoundaryEdge>& edges, float radius_m);

    template <class T>
    static void prefetch(const T& t) {
        for (size_t byte = 0; byte < sizeof t; byte += 64)
            __builtin_prefetch(static_cast<const char*>(static_cast<const void*>(&t)) + byte);
    }

    size_t size_ = 0;
    size_t depth_ = 1;                                 // of the leaves
    std::array<size_t, kMostDepth + 1> first_node_{};  // by depth
    std::vector<Node> nodes_;
    std::vector<EdgeBlock> blocks_;
    CubicCells cells_;
    int bit_shift_ = 0;
    std::vector<uint64_t> occupied_;  // one bit for the cells of each hash
};

template <class Visit>
bool BoundaryTree::visit_blocks(const vec3& p, const vec3& normal, float radius_m, float thickness_m, Limit limit,
                                const Visit& visit) const {
    if (size_ == 0) return true;
    constexpr float kRounding = 1e-5f;  // of cosines
    const Vec3Lanes at = broadcast(p), n = broadcast(normal), slope = broadcast(glm::abs(normal));
    struct Waiting {
        uint32_t depth, k;
    };
    std::array<Waiting, kWidth * kMostDepth + kWidth> stack;
    size_t waiting = 1;
    stack[0] = {0, 0};
    // Which children are reached cannot be foretold: they are noted without branches, and blocks fetched ahead of use.
    constexpr size_t kAhead = 4;
    std::array<uint32_t, kMostBlocks + kWidth> blocks;
    size_t noted = 0;
    const auto visit_noted = [&] {
        for (size_t i = 0; i < std::min(kAhead, noted); ++i) prefetch(blocks_[blocks[i]]);
        for (size_t i = 0; i < noted; ++i) {
            if (i + kAhead < noted) prefetch(blocks_[blocks[i + kAhead]]);
            visit(blocks_[blocks[i]]);
        }
        noted = 0;
    };
    while (waiting > 0) {
        const Waiting next = stack[--waiting];
        const Node& node = nodes_[first_node_[next.depth] + next.k];
        const Vec3Lanes to = node.centre.load() - at, half = node.half.load();
        const FloatLanes zero = 0;
        const FloatLanes x = max(abs(to.x) - half.x, zero), y = max(abs(to.y) - half.y, zero),
                         z = max(abs(to.z) - half.z, zero);
        // The cosines of the normals lie within `reach` of `cosine`: does a limit of the cones lie among them?
        const FloatLanes cosine = abs(dot(node.normal_centre.load(), n));
        const FloatLanes reach = dot(node.normal_half.load(), slope) + kRounding;
        const FloatMask reached = x * x + y * y + z * z <= sqr(radius_m) &&
                                  abs(dot(to, n)) <= thickness_m + dot(slope, half) &&
                                  abs(cosine - kSameSurface) <= reach;
        const uint32_t first = next.k * uint32_t{kWidth};
        if (next.depth + 1 == depth_) {
            for (uint32_t i = 0; i < kWidth; ++i) {
                blocks[noted] = first + i;
                noted += reached[i];
            }
            if (noted > kMostBlocks) {
                if (limit == Limit::Limited) return false;
                visit_noted();
            }
        } else {
            for (uint32_t i = 0; i < kWidth; ++i) {
                stack[waiting] = {next.depth + 1, first + i};
                waiting += reached[i];
            }
        }
    }
    visit_noted();
    return true;
}

}  // namespace photond

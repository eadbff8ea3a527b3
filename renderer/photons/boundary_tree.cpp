#include "renderer/photons/boundary_tree.h"

#include <algorithm>
#include <atomic>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr float kNormalWeight = 0.5f;

}  // namespace

BoundaryTree::BoundaryTree(std::vector<BoundaryEdge> edges, float radius_m) : size_(edges.size()) {
    if (edges.empty()) return;
    while (size_ > part_size(0)) ++depth_;
    for (size_t depth = 0; depth < depth_; ++depth)
        first_node_[depth + 1] = first_node_[depth] + parts(kWidthBits * depth);
    for (size_t level = 0; level < kWidthBits * depth_; ++level) {
        const size_t count = parts(level);
        parallel_for(count, count / 256 + 1, [&](size_t k) { split(edges, level, k, radius_m); });
    }
    Node none;
    for (auto& axis : none.half.axis) axis.fill(-kInfinity);
    nodes_.assign(first_node_[depth_], none);
    for (size_t depth = 1; depth <= depth_; ++depth)
        parallel_for(parts(kWidthBits * depth), 64, [&](size_t k) { bound_child(edges, depth, k); });
    blocks_.resize(parts(kWidthBits * depth_));
    parallel_for(blocks_.size(), 64, [&](size_t k) { fill_block(edges, k); });
    fill_cells(edges, radius_m);
}

/// Parts a range in two where edges differ most: in place, in length, so that long edges do not blow up the boxes of
/// short ones, or in their normals.
void BoundaryTree::split(std::vector<BoundaryEdge>& edges, size_t level, size_t k, float radius_m) {
    const size_t begin = k * part_size(level), end = std::min(size_, begin + part_size(level)),
                 middle = begin + part_size(level + 1);
    if (middle >= end) return;
    // A normal's whole range against a place's: both should end up small against what a disc takes of them.
    const float normal_m = kNormalWeight * radius_m;
    const auto length_of = [](const BoundaryEdge& e) {
        const vec3 d = glm::abs(e.b - e.a);
        return std::max({d.x, d.y, d.z});
    };
    Bounds3 middles, normals;
    float shortest = kInfinity, longest = 0;
    for (size_t i = begin; i < end; ++i) {
        const BoundaryEdge& e = edges[i];
        middles.extend(0.5f * (e.a + e.b));
        normals.extend(0.5f * (e.normal + e.other_normal));
        shortest = std::min(shortest, length_of(e)), longest = std::max(longest, length_of(e));
    }
    const vec3 d = middles.diagonal(), n = normal_m * normals.diagonal();
    const auto largest = [](const vec3& v) { return v.x > v.y && v.x > v.z ? 0 : v.y > v.z ? 1 : 2; };
    const int axis = largest(d), normal_axis = largest(n);
    const auto part = [&](const auto& key) {
        const auto at = [&](size_t i) { return edges.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(at(begin), at(middle), at(end),
                         [&](const BoundaryEdge& e, const BoundaryEdge& f) { return key(e) < key(f); });
    };
    if (longest - shortest > std::max(d[axis], n[normal_axis])) {
        part(length_of);
    } else if (n[normal_axis] > d[axis]) {
        part([&](const BoundaryEdge& e) { return e.normal[normal_axis] + e.other_normal[normal_axis]; });
    } else {
        part([&](const BoundaryEdge& e) { return e.a[axis] + e.b[axis]; });
    }
}

/// Sets the boxes of the k-th part of that depth in its parent.
void BoundaryTree::bound_child(const std::vector<BoundaryEdge>& edges, size_t depth, size_t k) {
    const size_t size = part_size(kWidthBits * depth), begin = k * size, end = std::min(size_, begin + size);
    Bounds3 bounds, normals;
    for (size_t i = begin; i < end; ++i) {
        const BoundaryEdge& e = edges[i];
        bounds.extend(e.a), bounds.extend(e.b);
        normals.extend(e.normal), normals.extend(e.other_normal);
    }
    Node& parent = nodes_[first_node_[depth - 1] + k / kWidth];
    const size_t lane = k % kWidth;
    // Rounding must not let an edge stick out.
    const vec3 largest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
    parent.centre.set(lane, bounds.centre());
    parent.half.set(lane, 0.5f * bounds.diagonal() + 0x1p-22f * largest);
    parent.normal_centre.set(lane, normals.centre());
    parent.normal_half.set(lane, 0.5f * normals.diagonal());
}

void BoundaryTree::fill_block(const std::vector<BoundaryEdge>& edges, size_t k) {
    EdgeBlock& block = blocks_[k];
    for (size_t lane = 0; lane < kWidth && k * kWidth + lane < size_; ++lane) {
        const BoundaryEdge& e = edges[k * kWidth + lane];
        block.a.set(lane, e.a);
        block.ab.set(lane, e.b - e.a);
        block.normal.set(lane, e.normal);
        block.other_normal.set(lane, e.other_normal);
        block.continues_at_m[lane] = e.continues_at_m;
    }
}

void BoundaryTree::fill_cells(const std::vector<BoundaryEdge>& edges, float radius_m) {
    Bounds3 bounds;
    double length_m = 0;
    for (const BoundaryEdge& e : edges) bounds.extend(e.a), bounds.extend(e.b), length_m += glm::length(e.b - e.a);
    cells_.origin = bounds.min;
    // Cells of twice the radius: an edge reaches into some eight of them. Larger where long edges would take too many,
    // or cells could not be counted in floats.
    const vec3 size = bounds.diagonal();
    const double most_layers = 4 * static_cast<double>(edges.size()) + 65536;
    cells_.per_m = 1 / std::max({2 * radius_m, static_cast<float>(length_m / most_layers),
                                 std::max({size.x, size.y, size.z}) * 0x1p-20f});

    std::atomic<uint64_t> visits = 0;
    parallel_for(edges.size(), 1024, [&](size_t i) {
        uint64_t own = 0;
        cells_.for_cells_within(edges[i].a, edges[i].b, radius_m, [&](const vec3&) { ++own; });
        visits.fetch_add(own, std::memory_order_relaxed);
    });
    constexpr uint64_t kFewestBits = 1 << 12, kMostBits = 1 << 25;  // 4 MiB: cells beyond share bits
    const uint64_t bits = std::clamp(std::bit_ceil(visits.load()), kFewestBits, kMostBits);
    bit_shift_ = 64 - std::countr_zero(bits);
    occupied_.assign(bits / 64, 0);
    parallel_for(edges.size(), 1024, [&](size_t i) {
        cells_.for_cells_within(edges[i].a, edges[i].b, radius_m, [&](const vec3& cell) {
            const uint64_t bit = CubicCells::hash(cell) >> bit_shift_;
            const std::atomic_ref<uint64_t> word(occupied_[bit / 64]);
            const uint64_t mask = uint64_t{1} << (bit % 64);
            if ((word.load(std::memory_order_relaxed) & mask) == 0) word.fetch_or(mask, std::memory_order_relaxed);
        });
    });
}

}  // namespace photond

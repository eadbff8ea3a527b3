#include "renderer/photons/boundary_tree.h"

#include <algorithm>
#include <atomic>

#include "renderer/core/parallel.h"

namespace photond {

BoundaryTree::BoundaryTree(std::vector<BoundaryEdge> edges, float radius_m) : edges_(std::move(edges)) {
    if (edges_.empty()) return;
    while (edges_.size() > kWidth << kWidthBits * depth_) ++depth_;
    Node none;
    for (auto& axis : none.centre) axis.fill(0);
    for (auto& axis : none.half) axis.fill(-kInfinity);
    nodes_.assign(node_index(depth_, 0), none);
    for (size_t level = 0; level <= kWidthBits * depth_; ++level) {
        const size_t parts = size_t{1} << level;
        parallel_for(parts, parts / 256 + 1, [&](size_t k) { split(level, k); });
    }
    fill_cells(radius_m);
}

/// Splits where edges differ most: in place, or in length, so that long edges do not blow up the boxes of short ones.
void BoundaryTree::split(size_t level, size_t k) {
    const size_t begin = first_edge(level, k), end = first_edge(level, k + 1);
    Bounds3 bounds, middles;
    float shortest = kInfinity, longest = 0;
    const auto length_of = [](const BoundaryEdge& e) {
        const vec3 d = glm::abs(e.b - e.a);
        return std::max({d.x, d.y, d.z});
    };
    for (size_t i = begin; i < end; ++i) {
        const BoundaryEdge& e = edges_[i];
        bounds.extend(e.a), bounds.extend(e.b);
        middles.extend(0.5f * (e.a + e.b));
        shortest = std::min(shortest, length_of(e)), longest = std::max(longest, length_of(e));
    }
    if (level > 0 && level % kWidthBits == 0 && !bounds.empty()) {
        // Rounding must not let an edge stick out.
        const vec3 largest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
        const vec3 centre = bounds.centre(), half = 0.5f * bounds.diagonal() + 0x1p-22f * largest;
        Node& parent = nodes_[node_index(level / kWidthBits - 1, k / kWidth)];
        for (int axis = 0; axis < 3; ++axis) {
            parent.centre[static_cast<size_t>(axis)][k % kWidth] = centre[axis];
            parent.half[static_cast<size_t>(axis)][k % kWidth] = half[axis];
        }
    }
    if (level == kWidthBits * depth_) return;
    const size_t middle = first_edge(level + 1, 2 * k + 1);
    if (begin < middle && middle < end) {
        const vec3 d = middles.diagonal();
        const int axis = d.x > d.y && d.x > d.z ? 0 : d.y > d.z ? 1 : 2;
        const auto at = [&](size_t i) { return edges_.begin() + static_cast<std::ptrdiff_t>(i); };
        if (longest - shortest > d[axis]) {
            std::nth_element(at(begin), at(middle), at(end),
                             [&](const BoundaryEdge& e, const BoundaryEdge& f) { return length_of(e) < length_of(f); });
        } else {
            std::nth_element(at(begin), at(middle), at(end), [&](const BoundaryEdge& e, const BoundaryEdge& f) {
                return e.a[axis] + e.b[axis] < f.a[axis] + f.b[axis];
            });
        }
    }
}

/// Walks along the edge's major axis, one layer of cells at a time.
template <class Visit>
void BoundaryTree::for_cells_within(const BoundaryEdge& e, float radius_m, const Visit& visit) const {
    const float reach = 1.0001f * radius_m * per_cell_ + 1e-3f;  // in cells; more than rounding can take away
    const vec3 a = (e.a - origin_) * per_cell_, d = (e.b - origin_) * per_cell_ - a, size = glm::abs(d);
    const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const float last = std::floor(std::max(a[axis], a[axis] + d[axis]) + reach);
    for (float layer = std::floor(std::min(a[axis], a[axis] + d[axis]) - reach); layer <= last; ++layer) {
        // The part of the edge that is within reach of the layer.
        float t0 = 0, t1 = 1;
        if (size[axis] > 0) {
            const float from = (layer - reach - a[axis]) / d[axis], to = (layer + 1 + reach - a[axis]) / d[axis];
            t0 = std::clamp(std::min(from, to), 0.0f, 1.0f), t1 = std::clamp(std::max(from, to), 0.0f, 1.0f);
        }
        const vec3 p = a + t0 * d, q = a + t1 * d;
        const vec3 low = glm::floor(glm::min(p, q) - reach), high = glm::floor(glm::max(p, q) + reach);
        vec3 cell;
        cell[axis] = layer;
        for (cell[u] = low[u]; cell[u] <= high[u]; ++cell[u]) {
            for (cell[v] = low[v]; cell[v] <= high[v]; ++cell[v]) visit(hash_cell(cell));
        }
    }
}

void BoundaryTree::fill_cells(float radius_m) {
    Bounds3 bounds;
    double length_m = 0;
    for (const BoundaryEdge& e : edges_) bounds.extend(e.a), bounds.extend(e.b), length_m += glm::length(e.b - e.a);
    origin_ = bounds.min;
    // Cells of twice the radius: an edge reaches into some eight of them. Larger where long edges would take too many,
    // or cells could not be counted in floats.
    const vec3 size = bounds.diagonal();
    const double most_layers = 4 * static_cast<double>(edges_.size()) + 65536;
    per_cell_ = 1 / std::max({2 * radius_m, static_cast<float>(length_m / most_layers),
                              std::max({size.x, size.y, size.z}) * 0x1p-20f});

    std::atomic<uint64_t> visits = 0;
    parallel_for(edges_.size(), 1024, [&](size_t i) {
        uint64_t own = 0;
        for_cells_within(edges_[i], radius_m, [&](uint64_t) { ++own; });
        visits.fetch_add(own, std::memory_order_relaxed);
    });
    constexpr uint64_t kFewestBits = 1 << 12, kMostBits = 1 << 25;  // 4 MiB: cells beyond share bits
    const uint64_t bits = std::clamp(std::bit_ceil(visits.load()), kFewestBits, kMostBits);
    bit_shift_ = 64 - std::countr_zero(bits);
    occupied_.assign(bits / 64, 0);
    parallel_for(edges_.size(), 1024, [&](size_t i) {
        for_cells_within(edges_[i], radius_m, [&](uint64_t hash) {
            const uint64_t bit = hash >> bit_shift_;
            const std::atomic_ref<uint64_t> word(occupied_[bit / 64]);
            const uint64_t mask = uint64_t{1} << (bit % 64);
            if ((word.load(std::memory_order_relaxed) & mask) == 0) word.fetch_or(mask, std::memory_order_relaxed);
        });
    });
}

}  // namespace photond

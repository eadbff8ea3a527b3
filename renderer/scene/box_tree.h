#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// Boxes in a balanced tree: which of them meet another box.
class BoxTree {
public:
    explicit BoxTree(const std::vector<Bounds3>& boxes) : boxes_(boxes), order_(boxes.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
        if (!boxes.empty()) nodes_.resize(2 * boxes.size());
        if (!boxes.empty()) build(0, 0, boxes.size());
    }

    /// Calls visit(index) for each box that meets `box`, touching included.
    template <class Visit>
    void for_each(const Bounds3& box, const Visit& visit) const {
        if (!boxes_.empty()) descend(0, 0, boxes_.size(), box, visit);
    }

private:
    static constexpr size_t kLeaf = 4;

    static bool meet(const Bounds3& a, const Bounds3& b) {
        return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
               a.min.z <= b.max.z && b.min.z <= a.max.z;
    }

    // A node stands before its first child; the second follows all of the first's, which are fewer than twice its
    // boxes.
    static size_t second_child(size_t node, size_t first, size_t middle) { return node + 2 * (middle - first); }

    void build(size_t node, size_t first, size_t last) {
        Bounds3 bounds, centres;
        for (size_t i = first; i < last; ++i) {
            bounds.extend(boxes_[order_[i]].min), bounds.extend(boxes_[order_[i]].max);
            centres.extend(boxes_[order_[i]].centre());
        }
        nodes_[node] = bounds;
        if (last - first <= kLeaf) return;
        const vec3 extent = centres.diagonal();
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const size_t middle = (first + last) / 2;
        const auto at = [&](size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(at(first), at(middle), at(last),
                         [&](uint32_t a, uint32_t b) { return boxes_[a].centre()[axis] < boxes_[b].centre()[axis]; });
        build(node + 1, first, middle);
        build(second_child(node, first, middle), middle, last);
    }

    template <class Visit>
    void descend(size_t node, size_t first, size_t last, const Bounds3& box, const Visit& visit) const {
        if (!meet(nodes_[node], box)) return;
        if (last - first <= kLeaf) {
            for (size_t i = first; i < last; ++i)
                if (meet(boxes_[order_[i]], box)) visit(order_[i]);
            return;
        }
        const size_t middle = (first + last) / 2;
        descend(node + 1, first, middle, box, visit);
        descend(second_child(node, first, middle), middle, last, box, visit);
    }

    const std::vector<Bounds3>& boxes_;
    std::vector<uint32_t> order_;
    std::vector<Bounds3> nodes_;
};

}  // namespace photond

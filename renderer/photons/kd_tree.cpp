#include "renderer/photons/kd_tree.h"

#include <cassert>

#include "renderer/core/parallel.h"
#include "renderer/photons/nearest_candidates.h"

namespace photond {

// --- Building

class KdTree::Builder {
public:
    Builder(KdTree& tree, std::span<const vec3> points, std::span<uint32_t> order)
        : tree_(tree), order_(order), last_level_(std::bit_ceil(tree.leaves())), records_(points.size()) {
        parallel_for(points.size(), 1 << 14, [&](size_t i) { records_[i] = {points[i], static_cast<uint32_t>(i)}; });
        tree_.bounds_ = bounds(0, records_.size());
        build(1, 0, records_.size());
    }

private:
    struct Record {
        vec3 p;
        uint32_t index;
    };
    static constexpr size_t kParallel = 1 << 12;  // points that are worth a task

    Bounds3 bounds(size_t first, size_t last) const {
        Bounds3 box;
        for (size_t i = first; i < last; ++i) box.extend(records_[i].p);
        return box;
    }

    /// First point of the leftmost bucket below a node.
    size_t first_point(uint32_t node) const {
        while (node < tree_.leaves()) node *= 2;
        return size_t{tree_.bucket_of(node, last_level_)} * kBucket;
    }

    void build(uint32_t node, size_t first, size_t last) {
        if (node >= tree_.leaves()) {
            fill(tree_.buckets_[first / kBucket], first, last);
            return;
        }
        const vec3 extent = bounds(first, last).diagonal();
        const uint32_t axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const size_t middle = first_point(2 * node + 1);
        const auto at = [&](size_t i) { return records_.begin() + static_cast<std::ptrdiff_t>(i); };
        std::nth_element(at(first), at(middle), at(last),
                         [a = static_cast<int>(axis)](const Record& l, const Record& r) { return l.p[a] < r.p[a]; });
        tree_.planes_[node] = {records_[middle].p[static_cast<int>(axis)], axis};
        const auto left = [&] { build(2 * node, first, middle); };
        const auto right = [&] { build(2 * node + 1, middle, last); };
        if (last - first >= kParallel) {
            parallel_invoke(left, right);
        } else {
            left();
            right();
        }
    }

    void fill(Bucket& bucket, size_t first, size_t last) {
        for (uint32_t lane = 0; lane < kBucket; ++lane) {
            const bool there = first + lane < last;
            bucket.set(lane, there ? records_[first + lane].p : vec3(kInfinity));
            if (there) order_[first + lane] = records_[first + lane].index;
        }
    }

    KdTree& tree_;
    std::span<uint32_t> order_;
    const uint32_t last_level_;
    std::vector<Record> records_;
};

KdTree::KdTree(std::span<const vec3> points, std::span<uint32_t> order) : size_(static_cast<uint32_t>(points.size())) {
    assert(order.size() == points.size());
    assert(points.size() <= UINT32_MAX - 1023 && "indices are of 32 bits");
    if (points.empty()) return;
    buckets_.resize((points.size() + kBucket - 1) / kBucket);
    planes_.resize(buckets_.size());
    Builder(*this, points, order);
}

uint64_t KdTree::bytes() const { return planes_.capacity() * sizeof(Plane) + buckets_.capacity() * sizeof(Bucket); }

uint64_t KdTree::bytes_for(uint64_t points) {
    return (points + kBucket - 1) / kBucket * (sizeof(Plane) + sizeof(Bucket));
}

uint64_t KdTree::build_bytes_for(uint64_t points) { return points * (sizeof(vec3) + sizeof(uint32_t)); }

// --- The k nearest

void KdTree::find_nearest(const vec3& p, uint32_t k, float max_radius_m, Neighbours& out) const {
    assert(k >= 2);
    // The first bound is taken as soon as there are k; later ones when selecting costs little against what has come.
    const uint32_t slack = std::max(k / 4, 16u), full = k + 2 * slack;
    uint32_t limit = k;
    NearestCandidates candidates(out, full, kBucket);
    traverse(p, sqr(max_radius_m), [&](uint32_t bucket, float bound_sq) {
        candidates.append_nearer(buckets_[bucket], p, bound_sq, bucket * kBucket);
        if (candidates.size() < limit) return bound_sq;
        limit = full;
        bound_sq = candidates.select(k, k + slack, bound_sq);
        candidates.keep(k + slack, bound_sq);
        return bound_sq;
    });
    if (candidates.size() < k) {
        out.radius_m = max_radius_m;
        candidates.take_all(out.found);
    } else {
        const float distance_sq = candidates.select(k, k, kInfinity);
        out.radius_m = std::sqrt(distance_sq);
        candidates.take(k - 1, distance_sq, out.found);
    }
}

void KdTree::find_within(const vec3& p, float radius_m, Neighbours& out) const {
    out.found.clear();
    out.radius_m = radius_m;
    traverse(p, sqr(radius_m), [&](uint32_t bucket, float bound_sq) {
        float distances_sq[kBucket];
        uint32_t indices[kBucket];
        const uint32_t count = buckets_[bucket].append_nearer(p, bound_sq, bucket * kBucket, distances_sq, indices);
        for (uint32_t i = 0; i < count; ++i) out.found.push_back({distances_sq[i], indices[i]});
        return bound_sq;
    });
}

}  // namespace photond

#pragma once
// The k nearest of many points: a left-balanced kd-tree without pointers.
//
// The points are rearranged into buckets of kBucket, which are the leaves of a complete, left-balanced binary tree: its
// inner nodes are one split plane each, in heap order, and no child is stored. A bucket is searched with vector
// instructions. [Jensen 1996]'s tree has one photon a node; buckets keep its shape and its lack of pointers, and take
// the last five or six levels, where nearly all the time goes, at the speed of a loop.
//
// A search keeps, for each axis, how far the query point lies outside a node's cell [Arya and Mount 1993], nearest
// cells first. Candidates nearer than the bound are appended, unsorted; when enough have come, the k-th nearest of them
// is selected and becomes the bound: work in proportion to the candidates, whatever k is.
//
// [Arya and Mount 1993] Algorithms for Fast Vector Quantization. Data Compression Conference.

#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/photons/neighbours.h"
#include "renderer/photons/point_bucket.h"

namespace photond {

class KdTree {
public:
    /// Points of a bucket; only the last bucket has fewer. Of 16, 32, 48 and 64 this was the fastest on the whole.
    static constexpr uint32_t kBucket = 48;

    KdTree() = default;
    /// Builds in parallel; the tree is the same for any number of threads. `order`, as long as `points`, is set so that
    /// the tree's point i is points[order[i]]. Coincident points are allowed in any number. All coordinates finite; at
    /// most 2^32 - 2^10 points.
    KdTree(std::span<const vec3> points, std::span<uint32_t> order);

    size_t size() const { return size_; }
    vec3 position(uint32_t index) const { return buckets_[index / kBucket].get(index % kBucket); }

    /// The k nearest (k >= 2) within `max_radius_m` of p (strictly nearer): k - 1 of them in `out`, whose radius is the
    /// distance of the k-th; all of them, with max_radius_m, when there are fewer than k. Of points equally far as the
    /// k-th any may be left out, but always the same for the same tree. max_radius_m may be infinite: so is then the
    /// disc of fewer than k.
    void find_nearest(const vec3& p, uint32_t k, float max_radius_m, Neighbours& out) const;

    /// All points strictly nearer to p than radius_m, each once; the radius is `out`'s.
    void find_within(const vec3& p, float radius_m, Neighbours& out) const;

    /// The point nearest to p among those strictly nearer than max_radius_m that `accept(index)` takes; size() when
    /// there is none. accept is asked in no particular order, of few points that are not the answer.
    template <class Accept>
    uint32_t find_one(const vec3& p, float max_radius_m, const Accept& accept) const;

    uint64_t bytes() const;
    static uint64_t bytes_for(uint64_t points);
    /// Bytes taken besides, while a tree is built.
    static uint64_t build_bytes_for(uint64_t points);

private:
    using Bucket = PointBucket<kBucket>;
    struct Plane {
        float position;  // points left of it have coordinates <= this, points right of it >= this
        uint32_t axis;
    };
    class Builder;

    /// Calls visit(bucket, bound_sq), which returns the bound from then on, for every bucket whose cell may hold a
    /// point strictly nearer than the bound; nearest children first.
    template <class Visit>
    void traverse(const vec3& p, float bound_sq, const Visit& visit) const;

    // Of the heap: nodes 1 ... leaves - 1 are inner, `leaves` ... 2 leaves - 1 are buckets. Those of the last level,
    // which are leftmost, begin at bit_ceil(leaves).
    uint32_t leaves() const { return static_cast<uint32_t>(buckets_.size()); }
    uint32_t bucket_of(uint32_t node, uint32_t last_level) const {
        return node - last_level + (node < last_level ? leaves() : 0);
    }

    uint32_t size_ = 0;
    Bounds3 bounds_;
    std::vector<Plane> planes_;  // by node; none for 0
    std::vector<Bucket> buckets_;
};

template <class Visit>
void KdTree::traverse(const vec3& p, float bound_sq, const Visit& visit) const {
    struct Cell {
        float offset[3];  // from p to the cell along each axis, 0 within; signs do not matter
        uint32_t node;
        float distance_sq() const { return length_sq(offset[0], offset[1], offset[2]); }
    };
    Cell stack[33];  // at most one a level waits
    uint32_t waiting = 0;
    const float query[3] = {p.x, p.y, p.z};  // glm's operator[] would branch
    if (buckets_.empty()) return;
    const uint32_t leaves = this->leaves(), last_level = std::bit_ceil(leaves);
    const Plane* const planes = planes_.data();

    Cell cell{.offset = {}, .node = 1};
    for (int axis = 0; axis < 3; ++axis)
        cell.offset[axis] = std::max({bounds_.min[axis] - query[axis], query[axis] - bounds_.max[axis], 0.0f});
    if (!(cell.distance_sq() < bound_sq)) return;
    for (;;) {
        while (cell.node < leaves) {
            const Plane plane = planes[cell.node];
            const float offset = query[plane.axis] - plane.position;
            cell.node = 2 * cell.node + (offset >= 0);
            Cell& far = stack[waiting];
            far = cell;
            far.node ^= 1;
            far.offset[plane.axis] = offset;
            waiting += far.distance_sq() < bound_sq;  // without a branch
        }
        bound_sq = visit(bucket_of(cell.node, last_level), bound_sq);
        do {
            if (waiting == 0) return;
            cell = stack[--waiting];
        } while (!(cell.distance_sq() < bound_sq));
    }
}

template <class Accept>
uint32_t KdTree::find_one(const vec3& p, float max_radius_m, const Accept& accept) const {
    uint32_t found = size_;
    traverse(p, sqr(max_radius_m), [&](uint32_t bucket, float bound_sq) {
        alignas(64) int32_t orders[kBucket];
        buckets_[bucket].distance_orders(p, orders);
        for (;;) {
            int32_t least;
            const uint32_t lane = Bucket::nearest_lane(orders, least);
            if (!(float_of(least) < bound_sq)) return bound_sq;
            const uint32_t index = bucket * kBucket + lane;
            if (accept(index)) {
                found = index;
                return float_of(least);
            }
            orders[lane] = order_of(kInfinity);
        }
    });
    return found;
}

}  // namespace photond

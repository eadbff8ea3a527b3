#pragma once
// The k nearest of many points: a left-balanced kd-tree without pointers.
//
// The points are rearranged in place into buckets of kBucket, which are the leaves of a complete, left-balanced binary
// tree: its inner nodes are one split plane each, in heap order, and no child is stored. A bucket is searched with
// vector instructions. [Jensen 1996]'s tree has one photon a node; buckets keep its shape and its lack of pointers, and
// take the last four or five levels, where nearly all the time goes, at the speed of a loop.

#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/photons/neighbours.h"

namespace photond {

class KdTree {
public:
    /// Points of a bucket, at most. (The builder of the tree chooses it by measurement.)
    static constexpr uint32_t kBucket = 32;

    KdTree() = default;
    /// Builds in parallel; the tree is the same for any number of threads. `order`, as long as `points`, is set so that
    /// the tree's point i is points[order[i]]. Coincident points are allowed in any number. All coordinates finite.
    KdTree(std::span<const vec3> points, std::span<uint32_t> order);

    size_t size() const { return x_.size(); }

    /// The k nearest (k >= 2) within `max_radius_m` of p (strictly nearer): k - 1 of them in `out`, whose radius is the
    /// distance of the k-th; all of them, with max_radius_m, when there are fewer than k. Of points equally far as the
    /// k-th any may be left out, but always the same for the same tree. max_radius_m may be infinite if size() >= k.
    void find_nearest(const vec3& p, uint32_t k, float max_radius_m, Neighbours& out) const;

    /// The point nearest to p among those within max_radius_m that `accept(index)` takes; size() when there is none.
    template <class Accept>
    uint32_t find_one(const vec3& p, float max_radius_m, const Accept& accept) const;

    uint64_t bytes() const;
    static uint64_t bytes_for(uint64_t points);

private:
    std::vector<float> x_, y_, z_;  // in the tree's order
};

}  // namespace photond

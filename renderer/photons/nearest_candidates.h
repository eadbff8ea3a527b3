#pragma once
// The unsorted candidates of a search for the k nearest, and the selection of the k-th of them.

#include "renderer/photons/neighbours.h"
#include "renderer/photons/point_bucket.h"

namespace photond {

/// Lives in the caller's scratch for one search.
class NearestCandidates {
public:
    /// `most`: appending to fewer than these is allowed.
    NearestCandidates(Neighbours& scratch, uint32_t most, uint32_t bucket_size);

    uint32_t size() const { return size_; }

    /// The points of a bucket that are strictly nearer than the bound; `first_index` is that of lane 0.
    template <uint32_t kSize>
    void append_nearer(const PointBucket<kSize>& bucket, const vec3& p, float bound_sq, uint32_t first_index) {
        size_ += bucket.append_nearer(p, bound_sq, first_index, distances_sq_ + size_, indices_ + size_);
    }

    /// A squared distance d such that the number of candidates at d or nearer is at least k, and at most k_most unless
    /// several are equally far as the k-th. 1 <= k <= size(). No candidate is farther than `bound_sq`, which may be
    /// infinite. With k_most = k, d is the distance of the k-th.
    float select(uint32_t k, uint32_t k_most, float bound_sq);

    /// Keeps those at select()'s `distance_sq` and nearer; of those that are equally far only the first, when there are
    /// more than `most`. The order stays.
    void keep(uint32_t most, float distance_sq);

    /// The first `count` nearest, given the distance of a candidate that is not nearer than the last of them; of those
    /// that are equally far the first. In the order they were appended, but for these, which come last.
    void take(uint32_t count, float distance_sq, std::vector<Neighbours::Found>& out);
    void take_all(std::vector<Neighbours::Found>& out) const;

private:
    void fill_last_block();  // with infinity, which is kept by nothing
    void drop_from(float distance_sq);
    void drop_equals(uint32_t most, float distance_sq);

    float* distances_sq_;
    uint32_t* indices_;
    uint32_t size_ = 0;
};

}  // namespace photond

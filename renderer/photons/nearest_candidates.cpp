#include "renderer/photons/nearest_candidates.h"

#include <cassert>

namespace photond {

NearestCandidates::NearestCandidates(Neighbours& scratch, uint32_t most, uint32_t bucket_size) {
    const size_t room = size_t{most} + bucket_size + LaneBlock::kLanes;
    if (scratch.candidate_distances_sq_m2.size() < room) {
        scratch.candidate_distances_sq_m2.resize(room);
        scratch.candidate_indices.resize(room);
    }
    distances_sq_ = scratch.candidate_distances_sq_m2.data();
    indices_ = scratch.candidate_indices.data();
}

void NearestCandidates::fill_last_block() {
    for (uint32_t i = size_; i % LaneBlock::kLanes != 0; ++i) distances_sq_[i] = kInfinity;
}

void NearestCandidates::drop_from(float distance_sq) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < size_; i += LaneBlock::kLanes)
        kept +=
            LaneBlock(distances_sq_ + i, indices_ + i).store_below(distance_sq, distances_sq_ + kept, indices_ + kept);
    size_ = kept;
}

float NearestCandidates::select(uint32_t k, uint32_t k_most, float bound_sq) {
    assert(1 <= k && k <= k_most && k <= size_);
    fill_last_block();
    const uint32_t blocks_end = (size_ + LaneBlock::kLanes - 1) / LaneBlock::kLanes * LaneBlock::kLanes;
    // The k-th lies in [low, high]; `below` candidates are less than low, `up_to` at most high.
    int32_t low = 0, high = order_of(bound_sq);
    uint32_t below = 0, up_to = size_;
    if (bound_sq == kInfinity) high = split_at(order_of(kInfinity) - 1, distances_sq_, blocks_end).last_up_to;
    for (uint32_t step = 0; low < high; ++step) {
        // Photons on a surface are spread evenly in squared distance, so the proportional guess is nearly right. Every
        // fourth guess halves the interval of bits instead, which ends soon for any distribution.
        int32_t pivot = low + (high - low) / 2;
        if (step % 4 != 3) {
            const float wanted = 0.5f * static_cast<float>(k + k_most) - static_cast<float>(below);
            const float share = std::min(1.0f, (wanted - 0.5f) / static_cast<float>(up_to - below));
            pivot = std::clamp(order_of(float_of(low) + (float_of(high) - float_of(low)) * share), low, high - 1);
        }
        const PivotSplit split = split_at(pivot, distances_sq_, blocks_end);
        if (split.up_to >= k) {
            if (split.up_to <= k_most) return float_of(split.last_up_to);
            high = split.last_up_to;
            up_to = split.up_to;
        } else {
            if (split.up_to + 1 == k) return float_of(split.first_above);
            low = split.first_above;
            below = split.up_to;
        }
    }
    return float_of(high);
}

void NearestCandidates::keep(uint32_t most, float distance_sq) {
    fill_last_block();
    drop_from(std::nextafter(distance_sq, kInfinity));
    if (size_ > most) drop_equals(most, distance_sq);
}

void NearestCandidates::drop_equals(uint32_t most, float distance_sq) {
    uint32_t surplus = size_ - most, kept = size_;
    for (uint32_t i = size_; i-- > 0;) {  // the last go first, the rest moves up
        if (surplus > 0 && distances_sq_[i] == distance_sq) {
            --surplus;
            continue;
        }
        --kept;
        distances_sq_[kept] = distances_sq_[i];
        indices_[kept] = indices_[i];
    }
    assert(surplus == 0);
    std::copy(distances_sq_ + kept, distances_sq_ + size_, distances_sq_);
    std::copy(indices_ + kept, indices_ + size_, indices_);
    size_ = most;
}

void NearestCandidates::take(uint32_t count, float distance_sq, std::vector<Neighbours::Found>& out) {
    out.resize(count);
    // The equally far first, before dropping moves them: hardly ever more than one.
    fill_last_block();
    uint32_t nearer = 0, equals = 0;
    for (uint32_t i = 0; i < size_; ++i) nearer += distances_sq_[i] < distance_sq;
    assert(nearer <= count);
    for (uint32_t i = 0; nearer + equals < count; ++i)
        if (distances_sq_[i] == distance_sq) out[nearer + equals++] = {distances_sq_[i], indices_[i]};
    drop_from(distance_sq);
    for (uint32_t i = 0; i < nearer; ++i) out[i] = {distances_sq_[i], indices_[i]};
}

void NearestCandidates::take_all(std::vector<Neighbours::Found>& out) const {
    out.resize(size_);
    for (uint32_t i = 0; i < size_; ++i) out[i] = {distances_sq_[i], indices_[i]};
}

}  // namespace photond

#pragma once
// A few points side by side, tested against a sphere with vector instructions.

#include "renderer/photons/lane_blocks.h"

namespace photond {

/// Lanes of a bucket that hold no point are at infinity: nearer than no radius.
template <uint32_t kSize>
struct alignas(64) PointBucket {
    static_assert(kSize % LaneBlock::kLanes == 0);
    float x[kSize], y[kSize], z[kSize];

    vec3 get(uint32_t lane) const { return {x[lane], y[lane], z[lane]}; }
    void set(uint32_t lane, const vec3& p) { x[lane] = p.x, y[lane] = p.y, z[lane] = p.z; }

    /// Squared distances from p, as orders.
    void distance_orders(const vec3& p, int32_t* out) const {
        for (uint32_t i = 0; i < kSize; ++i) out[i] = order_of(length_sq(x[i] - p.x, y[i] - p.y, z[i] - p.z));
    }

    /// Appends the squared distances and the indices (`first_index` + lane) of the points strictly nearer than the
    /// square root of `bound_sq`; in the order of the lanes; returns how many. Up to kSize numbers are written to both.
    uint32_t append_nearer(const vec3& p, float bound_sq, uint32_t first_index, float* distances_sq_out,
                           uint32_t* indices_out) const {
        uint32_t count = 0;
        for (uint32_t i = 0; i < kSize; i += LaneBlock::kLanes)
            count += LaneBlock(x + i, y + i, z + i, p, first_index + i)
                         .store_below(bound_sq, distances_sq_out + count, indices_out + count);
        return count;
    }

    /// Of the distances as orders: the least, and the first lane that has it.
    static uint32_t nearest_lane(const int32_t* orders, int32_t& least) {
        least = orders[0];
        for (uint32_t i = 1; i < kSize; ++i) least = std::min(least, orders[i]);
#if defined(__AVX512F__)
        const __m512i wanted = _mm512_set1_epi32(least);
        for (uint32_t i = 0; i < kSize; i += 16)
            if (const uint32_t mask = _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(orders + i), wanted))
                return i + static_cast<uint32_t>(std::countr_zero(mask));
#endif
        uint32_t lane = 0;
        while (orders[lane] != least) ++lane;
        return lane;
    }
};

}  // namespace photond

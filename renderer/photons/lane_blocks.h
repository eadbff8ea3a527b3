#pragma once
// Squared distances and indices, sixteen at a time: the instructions the kd-tree's searches are made of. The same
// answers with AVX-512, with AVX2 and without either.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "renderer/core/geometry.h"

namespace photond {

/// The squared length every search compares; one rounding rule for all code paths, and monotonic in each coordinate's
/// magnitude, so that no point of a box is nearer, in floats, than the box.
inline float length_sq(float x, float y, float z) {
#ifdef FP_FAST_FMAF
    return std::fma(z, z, std::fma(y, y, x * x));
#else
    return x * x + y * y + z * z;
#endif
}

/// Order of floats >= 0 (and +infinity) is that of their bits, and the compiler may reorder minima of whole numbers.
inline int32_t order_of(float x) { return std::bit_cast<int32_t>(x); }
inline float float_of(int32_t order) { return std::bit_cast<float>(order); }

/// Sixteen squared distances and the indices they belong to.
class LaneBlock {
public:
    static constexpr uint32_t kLanes = 16;

    /// Distances from p of sixteen points, aligned to 64 bytes, whose indices begin with `first_index`.
    LaneBlock(const float* x, const float* y, const float* z, const vec3& p, uint32_t first_index);
    LaneBlock(const float* distances_sq, const uint32_t* indices);

    /// Writes those strictly below the bound one after another and returns how many they are. What the outputs hold
    /// beyond them, up to sixteen numbers, is overwritten too.
    uint32_t store_below(float bound_sq, float* distances_sq_out, uint32_t* indices_out) const;

private:
#if defined(__AVX512F__)
    __m512 distances_sq_;
    __m512i indices_;
#elif defined(__AVX2__) && defined(__FMA__)
    __m256 distances_sq_[2];
    __m256i indices_[2];
#else
    alignas(64) float distances_sq_[kLanes];
    alignas(64) uint32_t indices_[kLanes];
#endif
};

#if defined(__AVX512F__)

inline LaneBlock::LaneBlock(const float* x, const float* y, const float* z, const vec3& p, uint32_t first_index) {
    const __m512 dx = _mm512_sub_ps(_mm512_load_ps(x), _mm512_set1_ps(p.x));
    const __m512 dy = _mm512_sub_ps(_mm512_load_ps(y), _mm512_set1_ps(p.y));
    const __m512 dz = _mm512_sub_ps(_mm512_load_ps(z), _mm512_set1_ps(p.z));
    distances_sq_ = _mm512_fmadd_ps(dz, dz, _mm512_fmadd_ps(dy, dy, _mm512_mul_ps(dx, dx)));
    indices_ = _mm512_add_epi32(_mm512_set1_epi32(static_cast<int32_t>(first_index)),
                                _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
}

inline LaneBlock::LaneBlock(const float* distances_sq, const uint32_t* indices)
    : distances_sq_(_mm512_loadu_ps(distances_sq)), indices_(_mm512_loadu_si512(indices)) {}

inline uint32_t LaneBlock::store_below(float bound_sq, float* distances_sq_out, uint32_t* indices_out) const {
    const __mmask16 below = _mm512_cmp_ps_mask(distances_sq_, _mm512_set1_ps(bound_sq), _CMP_LT_OQ);
    // Compressing in a register and storing all of it is fast everywhere; vcompressps to memory is not (AMD Zen 4).
    _mm512_storeu_ps(distances_sq_out, _mm512_maskz_compress_ps(below, distances_sq_));
    _mm512_storeu_si512(indices_out, _mm512_maskz_compress_epi32(below, indices_));
    return static_cast<uint32_t>(std::popcount(static_cast<uint32_t>(below)));
}

#elif defined(__AVX2__) && defined(__FMA__)

/// For each mask of eight lanes, the lanes that bring those set to the front.
inline constexpr auto kLanesToFront = [] {
    std::array<std::array<uint8_t, 8>, 256> table{};
    for (uint32_t mask = 0; mask < 256; ++mask) {
        size_t to = 0;
        for (uint32_t lane = 0; lane < 8; ++lane)
            if (mask >> lane & 1) table[mask][to++] = static_cast<uint8_t>(lane);
    }
    return table;
}();

inline LaneBlock::LaneBlock(const float* x, const float* y, const float* z, const vec3& p, uint32_t first_index) {
    for (int half = 0; half < 2; ++half) {
        const int at = 8 * half;
        const __m256 dx = _mm256_sub_ps(_mm256_load_ps(x + at), _mm256_set1_ps(p.x));
        const __m256 dy = _mm256_sub_ps(_mm256_load_ps(y + at), _mm256_set1_ps(p.y));
        const __m256 dz = _mm256_sub_ps(_mm256_load_ps(z + at), _mm256_set1_ps(p.z));
        distances_sq_[half] = _mm256_fmadd_ps(dz, dz, _mm256_fmadd_ps(dy, dy, _mm256_mul_ps(dx, dx)));
        indices_[half] = _mm256_add_epi32(_mm256_set1_epi32(static_cast<int32_t>(first_index) + at),
                                          _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    }
}

inline LaneBlock::LaneBlock(const float* distances_sq, const uint32_t* indices) {
    for (int half = 0; half < 2; ++half) {
        distances_sq_[half] = _mm256_loadu_ps(distances_sq + 8 * half);
        indices_[half] = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(indices + 8 * half));
    }
}

inline uint32_t LaneBlock::store_below(float bound_sq, float* distances_sq_out, uint32_t* indices_out) const {
    const __m256 bound = _mm256_set1_ps(bound_sq);
    uint32_t count = 0;
    for (int half = 0; half < 2; ++half) {
        const auto below =
            static_cast<uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(distances_sq_[half], bound, _CMP_LT_OQ)));
        const __m256i to_front =
            _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kLanesToFront[below].data())));
        _mm256_storeu_ps(distances_sq_out + count, _mm256_permutevar8x32_ps(distances_sq_[half], to_front));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(indices_out + count),
                            _mm256_permutevar8x32_epi32(indices_[half], to_front));
        count += static_cast<uint32_t>(std::popcount(below));
    }
    return count;
}

#else

inline LaneBlock::LaneBlock(const float* x, const float* y, const float* z, const vec3& p, uint32_t first_index) {
    for (uint32_t i = 0; i < kLanes; ++i) {
        distances_sq_[i] = length_sq(x[i] - p.x, y[i] - p.y, z[i] - p.z);
        indices_[i] = first_index + i;
    }
}

inline LaneBlock::LaneBlock(const float* distances_sq, const uint32_t* indices) {
    std::copy_n(distances_sq, kLanes, distances_sq_);
    std::copy_n(indices, kLanes, indices_);
}

inline uint32_t LaneBlock::store_below(float bound_sq, float* distances_sq_out, uint32_t* indices_out) const {
    uint32_t count = 0;
    for (uint32_t i = 0; i < kLanes; ++i) {  // without branches: which points are nearer cannot be predicted
        distances_sq_out[count] = distances_sq_[i];
        indices_out[count] = indices_[i];
        count += distances_sq_[i] < bound_sq;
    }
    return count;
}

#endif

/// How a pivot divides numbers >= 0, given as orders.
struct PivotSplit {
    uint32_t up_to;       // how many are at the pivot or below
    int32_t last_up_to;   // the greatest of them; 0 without any
    int32_t first_above;  // the least of the others; INT32_MAX without any
};

/// `values` are a multiple of LaneBlock::kLanes.
inline PivotSplit split_at(int32_t pivot, const float* values, uint32_t count) {
    using Lanes = int32_t __attribute__((vector_size(LaneBlock::kLanes * sizeof(int32_t))));
    // The compiler halves these as it must; with AVX-512 the comparisons become masks.
    Lanes up_to{}, last_up_to{}, first_above = Lanes{} + INT32_MAX;
    for (uint32_t i = 0; i < count; i += LaneBlock::kLanes) {
        Lanes order;
        __builtin_memcpy(&order, values + i, sizeof order);
        const Lanes above = order > pivot;  // -1 where it is, else 0
        const Lanes if_up_to = order & ~above, if_above = order | (~above & INT32_MAX);
        up_to += above + 1;
        last_up_to = last_up_to > if_up_to ? last_up_to : if_up_to;
        first_above = first_above < if_above ? first_above : if_above;
    }
    PivotSplit split{0, 0, INT32_MAX};
    for (uint32_t lane = 0; lane < LaneBlock::kLanes; ++lane) {
        split.up_to += static_cast<uint32_t>(up_to[lane]);
        split.last_up_to = std::max<int32_t>(split.last_up_to, last_up_to[lane]);
        split.first_above = std::min<int32_t>(split.first_above, first_above[lane]);
    }
    return split;
}

}  // namespace photond

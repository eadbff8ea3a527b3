#pragma once
// Eight points side by side, as the compiler's own vectors: in the innermost loops of all they are worth their
// plainness (core/lanes.h's type is not always inlined).

#include <algorithm>
#include <array>

#include "renderer/core/rgb.h"
#include "renderer/photons/lane_blocks.h"

namespace photond::point_lanes {

inline constexpr size_t kCount = 8;
using Floats = float __attribute__((vector_size(kCount * sizeof(float))));
using Ints = int32_t __attribute__((vector_size(kCount * sizeof(int32_t))));  // and masks: -1 or 0

struct Vec3s {
    Floats x, y, z;
};

inline Floats load(const float* from) {
    Floats v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
inline Ints load(const int32_t* from) {
    Ints v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}

/// v where the mask is set, else 0.
inline Floats keep(const Ints& mask, const Floats& v) {
    Ints bits;
    __builtin_memcpy(&bits, &v, sizeof bits);
    bits &= mask;
    Floats kept;
    __builtin_memcpy(&kept, &bits, sizeof kept);
    return kept;
}
inline Floats absolute(const Floats& v) { return v < 0 ? -v : v; }
inline Floats dot(const Vec3s& a, const Vec3s& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Floats dot(const Vec3s& a, const vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

inline bool any(const Ints& mask) {
#if defined(__AVX__)
    return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)) != 0;
#else
    int32_t bits = 0;
    for (size_t lane = 0; lane < kCount; ++lane) bits |= mask[lane];
    return bits != 0;
#endif
}

/// Squared distances, rounded as searches of maps round them (length_sq()): that the same photons are found is what
/// forward and reverse gathering agree by.
inline Floats distances_sq(const Vec3s& v) {
#if defined(__AVX2__) && defined(__FMA__)
    return _mm256_fmadd_ps(v.z, v.z, _mm256_fmadd_ps(v.y, v.y, _mm256_mul_ps(v.x, v.x)));
#else
    Floats sums;
    for (size_t lane = 0; lane < kCount; ++lane) sums[lane] = length_sq(v.x[lane], v.y[lane], v.z[lane]);
    return sums;
#endif
}

}  // namespace photond::point_lanes

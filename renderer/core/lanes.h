#pragma once
// Several numbers at once: the machine's widest float vectors, for loops that treat many rays or paths alike.

#include <cstdint>
#include <experimental/simd>

#include "renderer/core/geometry.h"

namespace photond {

using FloatLanes = std::experimental::simd<float, std::experimental::simd_abi::deduce_t<float, 8>>;
using IntLanes = std::experimental::rebind_simd_t<int32_t, FloatLanes>;
using FloatMask = FloatLanes::mask_type;
inline constexpr size_t kLanes = FloatLanes::size();
/// Of arrays that lanes are loaded from whole. Each member of a struct takes a multiple of it: a wider one is padding.
inline constexpr size_t kLaneAlignment = std::experimental::memory_alignment_v<FloatLanes>;

struct Vec3Lanes {
    FloatLanes x, y, z;
};

inline Vec3Lanes broadcast(const vec3& v) { return {v.x, v.y, v.z}; }
inline Vec3Lanes operator+(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3Lanes operator-(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3Lanes operator*(const FloatLanes& s, const Vec3Lanes& v) { return {s * v.x, s * v.y, s * v.z}; }
inline Vec3Lanes operator*(const Vec3Lanes& a, const Vec3Lanes& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline FloatLanes dot(const Vec3Lanes& a, const Vec3Lanes& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3Lanes cross(const Vec3Lanes& a, const Vec3Lanes& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The floats' bits as whole numbers, and back.
inline IntLanes bits_of(const FloatLanes& x) {
    IntLanes bits;
    static_assert(sizeof bits == sizeof x);
    __builtin_memcpy(static_cast<void*>(&bits), static_cast<const void*>(&x), sizeof x);
    return bits;
}
inline FloatLanes float_from_bits(const IntLanes& bits) {
    FloatLanes x;
    __builtin_memcpy(static_cast<void*>(&x), static_cast<const void*>(&bits), sizeof x);
    return x;
}

/// `a` where the mask is set, else `b`.
inline FloatLanes select(const FloatMask& mask, const FloatLanes& a, FloatLanes b) {
    where(mask, b) = a;
    return b;
}

}  // namespace photond

#pragma once
// Several numbers at once: the machine's widest float vectors, for loops that treat many rays or paths alike.

#include <cstdint>
#include <experimental/simd>

#include "renderer/core/geometry.h"

namespace photond {

using FloatLanes = std::experimental::native_simd<float>;
using FloatMask = FloatLanes::mask_type;
inline constexpr size_t kLanes = FloatLanes::size();

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

/// `a` where the mask is set, else `b`.
inline FloatLanes select(const FloatMask& mask, const FloatLanes& a, FloatLanes b) {
    where(mask, b) = a;
    return b;
}

}  // namespace photond

#pragma once
// Whether a ray passes a surface that covers only some of the rays that reach it.

#include <cstring>

#include "renderer/core/rng.h"

namespace photond {

/// `coverage`: surface_coverage() at the hit. Between 0 and 1 it is the probability to be stopped, decided by a hash of
/// the ray in world space and of the triangle, so that the answer is a pure function of them.
inline bool passes_surface(const Ray& ray, uint32_t instance, uint32_t triangle, float coverage) {
    if (coverage <= 0 || coverage >= 1) return coverage <= 0;
    uint32_t bits[6];
    std::memcpy(bits, &ray.origin, sizeof(vec3));
    std::memcpy(bits + 3, &ray.direction, sizeof(vec3));
    uint64_t hash = uint64_t{instance} << 32 | triangle;
    for (const int i : {0, 2, 4}) hash = hash64(hash ^ (uint64_t{bits[i]} << 32 | bits[i + 1]));
    return to_unit_float(uint32_t(hash >> 32)) >= coverage;
}

}  // namespace photond

// GLSL twin of scene/alpha_test.h.
#ifndef PHOTOND_ALPHA_TEST_GLSL
#define PHOTOND_ALPHA_TEST_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/core/rng.glsl"

/// `coverage`: surface_coverage() at the hit. Between 0 and 1 it is the probability to be stopped, decided by a hash of
/// the ray in world space and of the triangle, so that the answer is a pure function of them.
bool passes_surface(Ray ray, uint instance, uint triangle, float coverage) {
    if (coverage <= 0.0 || coverage >= 1.0) return coverage <= 0.0;
    const uvec3 o = floatBitsToUint(ray.origin), d = floatBitsToUint(ray.direction);
    uint64_t hash = packUint2x32(uvec2(triangle, instance));
    hash = hash64(hash ^ packUint2x32(uvec2(o.y, o.x)));
    hash = hash64(hash ^ packUint2x32(uvec2(d.x, o.z)));
    hash = hash64(hash ^ packUint2x32(uvec2(d.z, d.y)));
    return to_unit_float(uint(hash >> 32)) >= coverage;
}

#endif

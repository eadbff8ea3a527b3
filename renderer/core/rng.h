#pragma once
// Counter-based random numbers: a number is a pure function of (seed, domain, pass, stream, dimension). There is no
// global generator and no thread-local state, so any pass can be rendered anywhere and in any order.

#include <cstdint>

#include "renderer/core/geometry.h"

namespace photond {

/// Keeps uses of the same (seed, pass, stream) apart: a reference never shares numbers with the job it judges.
enum class RandomDomain : uint32_t {
    Camera = 1,
    Photons = 2,
    Reference = 3,
    Test = 4,
    BuiltinScene = 5,
    ShadowPhotons = 6,
    Splats = 7,
    Stratification = 8,
    LightPaths = 9,
    Connections = 10,
    MergingDiscs = 11,
    Proxies = 12,
    CacheTraining = 13
};

/// A good 32-bit mixing function. [Wellons 2018] "Prospecting for Hash Functions", lowbias32.
constexpr uint32_t hash32(uint32_t x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    x ^= x >> 15;
    return x;
}

/// 64-bit finaliser. [Steele, Lea, Flood 2014] SplittableRandom, mix64 variant 13.
constexpr uint64_t hash64(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// The seed of a reference rendered for jobs of that seed: one to one, and unlike any seed that people choose. All the
/// random numbers of a rendering follow from its seed, so a reference shares none with the job it judges, whatever
/// method renders it.
constexpr uint64_t reference_seed(uint64_t seed) {
    return hash64(hash64(seed + 0x9e3779b97f4a7c15ull) ^ uint64_t{static_cast<uint32_t>(RandomDomain::Reference)}
                                                             << 32);
}

/// Uniform in [0, 1), 24 bits.
constexpr float to_unit_float(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

/// One stream of independent uniform numbers; `dimension` counts up as numbers are taken.
class RandomStream {
public:
    RandomStream(uint64_t seed, RandomDomain domain, uint32_t pass, uint64_t stream)
        : key_(hash64(hash64(hash64(seed + 0x9e3779b97f4a7c15ull) ^ (uint64_t{pass} << 32 | uint32_t(domain))) +
                      stream)) {}

    uint32_t next_bits() {
        key_ += 0x9e3779b97f4a7c15ull;  // Weyl sequence: the counter of the hash
        return static_cast<uint32_t>(hash64(key_) >> 32);
    }
    float next() { return to_unit_float(next_bits()); }
    vec2 next_2d() {
        const float x = next();
        return {x, next()};
    }

private:
    uint64_t key_;
};

}  // namespace photond

// GLSL twin of core/rng.h: the same numbers, bit for bit.
#ifndef PHOTOND_RNG_GLSL
#define PHOTOND_RNG_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

// RandomDomain.
#define RANDOM_DOMAIN_CAMERA 1u
#define RANDOM_DOMAIN_PHOTONS 2u
#define RANDOM_DOMAIN_REFERENCE 3u
#define RANDOM_DOMAIN_TEST 4u
#define RANDOM_DOMAIN_BUILTIN_SCENE 5u
#define RANDOM_DOMAIN_SHADOW_PHOTONS 6u
#define RANDOM_DOMAIN_SPLATS 7u
#define RANDOM_DOMAIN_STRATIFICATION 8u
#define RANDOM_DOMAIN_LIGHT_PATHS 9u
#define RANDOM_DOMAIN_CONNECTIONS 10u
#define RANDOM_DOMAIN_MERGING_DISCS 11u
#define RANDOM_DOMAIN_PROXIES 12u

/// A good 32-bit mixing function. [Wellons 2018] "Prospecting for Hash Functions", lowbias32.
uint hash32(uint x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    x ^= x >> 15;
    return x;
}

/// 64-bit finaliser. [Steele, Lea, Flood 2014] SplittableRandom, mix64 variant 13.
uint64_t hash64(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ul;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebul;
    return x ^ (x >> 31);
}

/// Uniform in [0, 1), 24 bits.
float to_unit_float(uint bits) { return float(bits >> 8) * 5.9604644775390625e-8; }  // 2^-24

/// One stream of independent uniform numbers.
struct RandomStream {
    uint64_t key;
};

RandomStream make_random_stream(uint64_t seed, uint domain, uint pass, uint64_t stream) {
    const uint64_t of_seed = hash64(seed + 0x9e3779b97f4a7c15ul);
    return RandomStream(hash64(hash64(of_seed ^ (uint64_t(pass) << 32 | uint64_t(domain))) + stream));
}

uint random_stream_next_bits(inout RandomStream stream) {
    stream.key += 0x9e3779b97f4a7c15ul;  // Weyl sequence: the counter of the hash
    return uint(hash64(stream.key) >> 32);
}
float random_stream_next(inout RandomStream stream) { return to_unit_float(random_stream_next_bits(stream)); }
vec2 random_stream_next_2d(inout RandomStream stream) {
    const float x = random_stream_next(stream);
    return vec2(x, random_stream_next(stream));
}

#endif

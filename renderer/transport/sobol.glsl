// GLSL twin of transport/sobol.h: the same numbers, bit for bit. Define SAMPLER_BINDING before the include where the
// numbers of a pass are wanted: the buffer of set 0 that holds its PassSamplerData.
#ifndef PHOTOND_SOBOL_GLSL
#define PHOTOND_SOBOL_GLSL

#include "renderer/core/rng.glsl"
#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/transport/sobol_shared.h"

/// Direction numbers by dimension and index bit, bits reversed.
layout(set = SCENE_SET, binding = SOBOL_BINDING, scalar) readonly buffer SobolDirections { uint sobol_directions[]; };

/// Owen scrambling of a fraction whose bits are given lowest first.
uint laine_karras(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// Two coordinates of the sequence, the most significant bit lowest: `dimension` and the one after.
uvec2 point_bits_reversed(uint index, uint dimension) {
    uvec2 bits = uvec2(0);
    for (uint at = SOBOL_INDEX_BITS * dimension; index != 0; ++at, index >>= 1)
        if ((index & 1u) != 0) bits ^= uvec2(sobol_directions[at], sobol_directions[at + SOBOL_INDEX_BITS]);
    return bits;
}

float scrambled_fraction(uint bits_reversed, uint seed) {
    return to_unit_float(bitfieldReverse(laine_karras(bits_reversed, seed)));
}

/// The point of two scrambled coordinates; `seeds`: x's in the upper half.
vec2 scrambled_point(uvec2 bits_reversed, uint64_t seeds) {
    return vec2(scrambled_fraction(bits_reversed.x, uint(seeds >> 32)), scrambled_fraction(bits_reversed.y, uint(seeds)));
}

vec2 unit_floats(uint64_t bits) { return vec2(to_unit_float(uint(bits >> 32)), to_unit_float(uint(bits))); }

#ifdef SAMPLER_BINDING

layout(set = 0, binding = SAMPLER_BINDING, scalar) readonly buffer PassSampler { PassSamplerData pass_sampler; };

SobolSetPoint make_set_point(uint set) {
    const uint block = set / SOBOL_SETS_IN_BLOCK;
    const uint shuffle_seed = uint(hash64(~(uint64_t(pass_sampler.set_salt) << 32 | uint64_t(block))) >> 32);
    const uint index = bitfieldReverse(laine_karras(bitfieldReverse(pass_sampler.pass), shuffle_seed));
    const uvec2 bits = point_bits_reversed(index, 2 * (set % SOBOL_SETS_IN_BLOCK));
    return SobolSetPoint(bits.x, bits.y, hash64(uint64_t(pass_sampler.set_salt) << 32 | uint64_t(set)));
}

/// Names a pixel's streams; different pixels never share one. Compute once a path.
uint pixel_key(uint pixel) { return hash32(pixel ^ pass_sampler.pixel_salt); }

/// A point in [0, 1)^2.
vec2 sample_2d(uint pixel_key, uint set) {
    if (pass_sampler.kind == SAMPLER_KIND_RANDOM)
        return unit_floats(hash64((uint64_t(pixel_key) << 32 | uint64_t(set)) ^ pass_sampler.random_key));
    SobolSetPoint point;
    if (set < SOBOL_PREPARED_SETS)
        point = pass_sampler.prepared[set];
    else
        point = make_set_point(set);
    return scrambled_point(uvec2(point.x_reversed, point.y_reversed), hash64(point.salt + uint64_t(pixel_key)));
}

#endif

/// SequenceSampler::sample_2d: a point in [0, 1)^2.
vec2 sequence_sample_2d(SequenceKey sequence, uint64_t index, uint set) {
    const uint64_t set_key = hash64(sequence.key + uint64_t(set));
    if (sequence.kind == SAMPLER_KIND_RANDOM || set >= SOBOL_SETS_IN_BLOCK)
        return unit_floats(hash64(set_key + index * 0x9e3779b97f4a7c15ul));
    return scrambled_point(point_bits_reversed(uint(index), 2 * set), hash64(set_key + ~(index >> 32)));
}

#endif

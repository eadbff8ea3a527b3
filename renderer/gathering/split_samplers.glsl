// GLSL twin of gathering/split_samplers.h: the numbers of vertices at which a path splits, into gather rays or
// into light samples. Define SPLIT_POINTS_BINDING (of set 0) beside SAMPLER_BINDING before: what split_samplers.comp made
// of the pass.
#ifndef PHOTOND_SPLIT_SAMPLERS_GLSL
#define PHOTOND_SPLIT_SAMPLERS_GLSL

#include "renderer/gathering/gathering_shared.h"
#include "renderer/transport/sobol.glsl"

/// How many of `all` samples a vertex gets: all for light that reaches the eye unweakened; fewer, in proportion, behind dim
/// reflections. `throughput` and `eta_scale` as in EyePath.
uint split_of(uint all, vec3 throughput, float eta_scale) {
    const float most = float(all);
    return uint(clamp(ceil(most * max(max(throughput.x, throughput.y), throughput.z) * eta_scale), 1.0, most));
}

/// The samplers of a pass whose sample i is element pass * samples + i of every vertex's sequence; `first_point`: where
/// sample 0's prepared points begin.
struct SplitSamplers {
    uint samples;
    uint first_point;
};

uint split_element(SplitSamplers samplers, uint i) { return pass_sampler.pass * samplers.samples + i; }

/// The set's unscrambled point of an element of the sequence: make_set_point() of sobol.glsl for any pass.
uvec2 split_point(uint element, uint set) {
    const uint block = set / SOBOL_SETS_IN_BLOCK;
    const uint shuffle_seed = uint(hash64(~(uint64_t(pass_sampler.set_salt) << 32 | uint64_t(block))) >> 32);
    const uint index = bitfieldReverse(laine_karras(bitfieldReverse(element), shuffle_seed));
    return point_bits_reversed(index, 2 * (set % SOBOL_SETS_IN_BLOCK));
}

#ifdef SPLIT_POINTS_BINDING
layout(set = 0, binding = SPLIT_POINTS_BINDING, scalar) readonly buffer SplitPoints { uvec2 split_points[]; };

/// samplers[i].sample_2d(key, set).
vec2 split_sample_2d(SplitSamplers samplers, uint i, uint key, uint set) {
    const uint64_t salts = uint64_t(pass_sampler.set_salt) << 32;
    if (pass_sampler.kind == SAMPLER_KIND_RANDOM) {
        const uint64_t random_key =
            hash64((salts | uint64_t(pass_sampler.pixel_salt)) + (uint64_t(split_element(samplers, i)) << 32 | 1ul));
        return unit_floats(hash64((uint64_t(key) << 32 | uint64_t(set)) ^ random_key));
    }
    uvec2 point;
    uint64_t salt;
    if (set < SPLIT_PREPARED_SETS) {
        point = split_points[samplers.first_point + i * SPLIT_PREPARED_SETS + set];
        salt = pass_sampler.prepared[set].salt;
    } else {
        point = split_point(split_element(samplers, i), set);
        salt = hash64(salts | uint64_t(set));
    }
    return scrambled_point(point, hash64(salt + uint64_t(key)));
}
#endif

#endif

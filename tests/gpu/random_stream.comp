#version 460
// Numbers of RandomStreams, and the hashes they are made of.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/core/rng.glsl"
#include "tests/gpu/twin.glsl"

struct Stream {
    uint64_t seed;
    uint64_t stream;
    uint domain;
    uint pass;
};
struct Numbers {
    uint64_t hash;
    uint bits[3];
    vec2 point;
    uint hash_of_bits;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Stream streams[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { Numbers numbers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Stream s = streams[i];
    RandomStream random = make_random_stream(s.seed, s.domain, s.pass, s.stream);
    Numbers n;
    n.hash = hash64(s.seed);
    for (int k = 0; k < 3; ++k) n.bits[k] = random_stream_next_bits(random);
    n.point = random_stream_next_2d(random);
    n.hash_of_bits = hash32(n.bits[0]);
    numbers[i] = n;
}

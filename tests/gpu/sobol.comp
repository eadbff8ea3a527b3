#version 460
// Points of a PassSampler and of a SequenceSampler.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define SAMPLER_BINDING 0
#include "renderer/transport/sobol.glsl"
#include "tests/gpu/twin.glsl"

struct Element {
    uint64_t index;
    uint pixel;
    uint set;
};
layout(set = 0, binding = 1, scalar) readonly buffer Keys { SequenceKey sequence; };
layout(set = 0, binding = 2, scalar) readonly buffer In { Element elements[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Out { vec2 points[]; };  // of the pass, of the sequence

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Element e = elements[i / 2];
    points[i] = i % 2 == 0 ? sample_2d(pixel_key(e.pixel), e.set) : sequence_sample_2d(sequence, e.index, e.set);
}

#version 460
// Texels of the scene's textures.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/scene/texture.glsl"
#include "tests/gpu/twin.glsl"

struct Lookup {
    int texture_index;
    uint srgb;
    vec2 uv;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Lookup lookups[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Out { vec4 answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    answers[i] = sample_texture(lookups[i].texture_index, lookups[i].uv, lookups[i].srgb != 0u);
}

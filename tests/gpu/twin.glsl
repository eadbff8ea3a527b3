// What tests/support/gpu_twin.h runs: include it after the inputs' and the output's declarations or before, and start
// main() with `const uint i = flat_index(); if (i >= count) return;`.
#ifndef PHOTOND_TWIN_GLSL
#define PHOTOND_TWIN_GLSL

#include "renderer/backends/gpu/invocation.glsl"

#define TWIN_GROUP 64
layout(local_size_x = TWIN_GROUP) in;
layout(push_constant, scalar) uniform Push { uint count; };

#endif

// What the shaders of PathSelectionGpu have in common. GLSL twin of many_lights/path_selection.cpp.
#ifndef PHOTOND_PATH_SELECTION_GLSL
#define PHOTOND_PATH_SELECTION_GLSL

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/many_lights/path_selection_shared.h"
#include "renderer/many_lights/vpl_tracer_shared.h"

layout(local_size_x = PATH_SELECTION_GROUP) in;
layout(push_constant, scalar) uniform Push { PathSelectionPush push; };

RandomStream numbers_of(uint stage, uint stream) {
    return make_random_stream(push.seed, RANDOM_DOMAIN_SPLATS, push.pass, uint64_t(stage) << 32 | uint64_t(stream));
}

#endif

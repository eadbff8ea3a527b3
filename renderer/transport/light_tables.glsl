// The lights' arrays of words and floats, and where everything is in them. Made by make_light_tables()
// (light_tables.h).
#ifndef PHOTOND_LIGHT_TABLES_GLSL
#define PHOTOND_LIGHT_TABLES_GLSL

#include "renderer/backends/gpu/scene.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/transport/light_tables_shared.h"

layout(set = SCENE_SET, binding = LIGHT_WORDS_BINDING, scalar) readonly buffer LightWords { uint light_words[]; };
layout(set = SCENE_SET, binding = LIGHT_FLOATS_BINDING, scalar) readonly buffer LightFloats { float light_floats[]; };
layout(set = SCENE_SET, binding = LIGHT_CONSTANTS_BINDING, scalar) readonly buffer LightConstantsBuffer {
    LightConstants light_constants;
};

/// Numbers of what casts one shadow: the emitting triangles of an instance together, each punctual light, the
/// environment.
uint light_source_of_instance(uint instance) { return instance; }
uint light_source_of_punctual(uint light) { return light_constants.instances + light; }
uint light_source_of_environment() { return light_constants.instances + light_constants.punctual_lights; }

#endif

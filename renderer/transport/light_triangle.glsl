// GLSL twin of transport/light_triangle.h and emitter.h: triangles that emit, points and spots.
#ifndef PHOTOND_LIGHT_TRIANGLE_GLSL
#define PHOTOND_LIGHT_TRIANGLE_GLSL

#include "renderer/transport/light_tables.glsl"

layout(set = SCENE_SET, binding = EMITTERS_BINDING, scalar) readonly buffer Emitters { EmitterRecord emitters[]; };

uint emitter_shape(EmitterRecord e) { return e.kind & EMITTER_SHAPE; }
bool emitter_two_sided(EmitterRecord e) { return has_flag(e.kind, EMITTER_TWO_SIDED); }
bool emitter_varies(EmitterRecord e) {
    return (NEEDS_EMISSION_TEXTURES || NEEDS_ALPHA) && has_flag(e.kind, EMITTER_VARIES);
}

/// Triangle i of Scene::triangle_lights, never part of a parallelogram.
EmitterRecord light_triangle(uint light) { return emitters[light_constants.first_triangle_light + light]; }

#endif

// Vertices of the eye's paths as they wait to be joined with light paths.
#ifndef PHOTOND_WAITING_JOINS_GLSL
#define PHOTOND_WAITING_JOINS_GLSL

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define WAVE_QUEUES_BINDING 3
#define BIDIRECTIONAL_BINDING 4
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/bidirectional/join_vertex.glsl"
#include "renderer/eye/path_state.glsl"
#include "renderer/eye/wave_queues.glsl"
#include "renderer/transport/bsdf_material.glsl"

layout(local_size_x = WAVE_GROUP) in;
layout(push_constant, scalar) uniform Push { PathWavePush push; };
layout(set = 0, binding = 5, scalar) readonly buffer Joins { JoinState joins[]; };

/// The vertex this thread has; false past the queue's end.
bool waiting_join(out uint key, out JoinVertex at) {
    const uint i = flat_index();
    if (i >= wave_queues[WAVE_NOW(WAVE_JOINS)]) return false;
    const JoinState join = joins[i];
    key = join.path.key;
    at.path = unpack_path(join.path);
    at.weights = join.weights;
    at.outside_ior = join.outside_ior;
    at.acceptance = join.acceptance;
    const vec3 direction = join.path.direction;
    at.surface.point = make_shading_point(Hit(0.0, join.instance, join.triangle, join.u, join.v), direction);
    at.surface.bsdf = make_bsdf(at.surface.point, join.outside_ior);
    at.surface.from = -direction;
    return true;
}

#endif

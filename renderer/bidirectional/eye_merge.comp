#version 460
// The wavefront's merging of vertices of the eye's paths.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define GRID_STARTS_BINDING 6
#define GRID_PLACES_BINDING 7
#define LIGHT_VERTICES_BINDING 8
#include "renderer/bidirectional/waiting_joins.glsl"
#include "renderer/bidirectional/eye_merge.glsl"

void main() {
    uint key;
    JoinVertex at;
    if (!waiting_join(key, at)) return;
    JoinedLight light = no_joined_light();
    merge_vertex(push.vertex, key, at, light);
    store_joined_light(at.path.pixel, light);
}

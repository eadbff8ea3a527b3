#version 460
// The wavefront's connections of vertices of the eye's paths.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define LIGHT_TABLES_BINDING 6
#define LIGHT_VERTICES_BINDING 7
#define LIGHT_ORDER_BINDING 8
#include "renderer/bidirectional/waiting_joins.glsl"
#include "renderer/bidirectional/eye_connect.glsl"

void main() {
    uint key;
    JoinVertex at;
    if (!waiting_join(key, at)) return;
    JoinedLight light = no_joined_light();
    uint shadow_rays = 0;
    connect_vertex(push.vertex, key, at, light, shadow_rays);
    store_joined_light(at.path.pixel, light);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}

// What joined paths bring to a pixel, by the parts of the image it belongs to (add_joined() of bidirectional_scene.h).
// Kept by the thread until it is done with them. Define IMAGE_BINDING (of set 0) before.
#ifndef PHOTOND_JOINED_LIGHT_GLSL
#define PHOTOND_JOINED_LIGHT_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "renderer/bidirectional/bidirectional_shared.h"
#include "renderer/eye/eye_contributions.glsl"

// Join.
#define JOIN_LIGHT_SAMPLE 0u
#define JOIN_CONNECTION 1u
#define JOIN_MERGE 2u
#define JOIN_LIGHT_IMAGE 3u

struct JoinedLight {
    vec3 direct, indirect, caustic;
    vec3 connections, merges, light_image;
};
JoinedLight no_joined_light() {
    return JoinedLight(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
}

/// Adds light of a path with so many scatterings, all of them delta beyond x_1 where `caustic` says so.
void add_joined(inout JoinedLight light, uint scatterings, bool caustic, uint join, vec3 radiance) {
    if (scatterings <= 1) {
        light.direct += radiance;
    } else {
        light.indirect += radiance;
        if (caustic) light.caustic += radiance;
    }
    if (join == JOIN_CONNECTION) light.connections += radiance;
    if (join == JOIN_MERGE) light.merges += radiance;
    if (join == JOIN_LIGHT_IMAGE) light.light_image += radiance;
}

/// Adds it to the pixel's layers.
void store_joined_light(uint pixel, JoinedLight light) {
    add_rgb(LAYER_DIRECT, pixel, light.direct);
    add_rgb(LAYER_INDIRECT, pixel, light.indirect);
    if (layer_kept(LAYER_CAUSTIC)) add_rgb(LAYER_CAUSTIC, pixel, light.caustic);
    if (layer_kept(LAYER_CONNECTIONS)) add_rgb(LAYER_CONNECTIONS, pixel, light.connections);
    if (layer_kept(LAYER_MERGES)) add_rgb(LAYER_MERGES, pixel, light.merges);
    if (layer_kept(LAYER_LIGHT_IMAGE)) add_rgb(LAYER_LIGHT_IMAGE, pixel, light.light_image);
}

#endif

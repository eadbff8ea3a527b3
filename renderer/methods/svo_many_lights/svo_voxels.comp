#version 460
// The first voxel on the ray through each pixel's centre, a thread a pixel: CPU twin show_voxels().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define SVO_CONSTANTS_BINDING 2
#define SVO_NODES_BINDING 3
#define SVO_BRICKS_BINDING 4
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/gbuffer/gbuffer_walk_shared.h"
#include "renderer/frame/device_image.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/scene/camera.glsl"
#include "renderer/voxels/svo_march.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(set = 0, binding = 1, scalar) readonly buffer Eye { EyeConstants eye; };

/// Of a brick: bright, and told apart from its neighbours.
vec3 brick_color(uvec3 voxel) {
    const uvec3 brick = voxel / uint(BRICK_SIDE);
    const uint bits = hash32(brick.x | brick.y << 8 | brick.z << 16);
    return 0.4 + 0.6 * vec3(bits & 0xffu, bits >> 8 & 0xffu, bits >> 16 & 0xffu) / 255.0;
}

/// Cosine between the ray and the face of the voxel it enters by.
float face_cosine(uvec3 voxel, float t, Ray ray) {
    const vec3 centre = svo_constants.grid.low + (vec3(voxel) + 0.5) * svo_constants.grid.cell_m;
    const vec3 from = abs(ray.origin + t * ray.direction - centre);
    return abs(from.x >= from.y && from.x >= from.z ? ray.direction.x
               : from.y >= from.z                   ? ray.direction.y
                                                    : ray.direction.z);
}

void main() {
    const uint pixel = flat_index();
    if (pixel >= eye.width * eye.height) return;
    const Ray ray = camera_ray(eye.camera, vec2(pixel % eye.width, pixel / eye.width) + 0.5, vec2(0.5));
    float t;
    uvec3 voxel;
    uint surface;
    vec3 shown = vec3(0.0);
    if (svo_first_voxel(ray, t, voxel, surface)) shown = brick_color(voxel) * face_cosine(voxel, t, ray);
    store_rgb(LAYER_VOXELS, pixel, shown);
}

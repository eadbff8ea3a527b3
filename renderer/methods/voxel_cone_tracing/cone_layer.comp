#version 460
// What a narrow cone from the eye sees through each pixel's middle, for the layer `cone_mip`: cells as large as they are
// far. A thread a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 6
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/frame/device_image.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_march.glsl"
#include "renderer/scene/camera.glsl"

layout(local_size_x = CONE_GROUP) in;
layout(push_constant, scalar) uniform Push { ConeMarch march; };
layout(set = 0, binding = 7, scalar) readonly buffer Eye { EyeConstants eye; };

const float kShownAperture = 0.02;

void main() {
    const uint pixel = flat_index();
    if (pixel >= eye.width * eye.height) return;
    const Ray ray = camera_ray(eye.camera, vec2(pixel % eye.width, pixel / eye.width) + 0.5, vec2(0.5));
    // Into the grid, where the cone may begin far from it.
    const vec3 origin = to_voxels(ray.origin), resolution = vec3(svo_constants.grid.resolution);
    const vec3 inverse = 1.0 / mix(ray.direction, vec3(1e-20), lessThan(abs(ray.direction), vec3(1e-20)));
    const vec3 enter = min(-origin * inverse, (resolution - origin) * inverse);
    const float first = max(max(enter.x, max(enter.y, enter.z)), 0.0) + 0.5;
    store_rgb(LAYER_CONE_MIP, pixel,
              cone_radiance(ConeStart(origin, vec3(0.0)), Cone(ray.direction, kShownAperture, march.step), first,
                            hash32(pixel ^ march.key)));
}

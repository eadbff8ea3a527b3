#version 460
// The parts of a pixel's light, brought into the image, a thread a pixel: indirect light of pixels that have none of
// their own, direct light with its soft shadow, and their sum; all at once, or a pipeline each.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/backends/gpu/scene.glsl"
#include "renderer/frame/device_image.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_combine_shared.h"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"
#include "renderer/eye/eye_shared.h"
#include "renderer/gbuffer/centre_shadows_shared.h"
#include "renderer/gbuffer/lamps_shared.h"
#include "renderer/gbuffer/upsampling_shared.h"

layout(constant_id = COMBINE_PARTS_ID) const uint PARTS = COMBINE_MERGE;

layout(local_size_x = SCATTER_GROUP) in;
layout(push_constant, scalar) uniform Push { ShadowSamples shadow_samples; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { PhotonScatterConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) buffer Sums { vec3 sums[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Eye { EyeConstants eye; };
layout(set = 0, binding = 5, scalar) readonly buffer LampShapes { LampShape lamp_shapes[]; };
layout(set = 0, binding = 6, scalar) readonly buffer UnshadowedLights { UnshadowedLight unshadowed_lights[]; };
#define SUB_POINTS points
#define SUB_SUMS sums
#include "renderer/gbuffer/upsampling.glsl"
#define UNSHADOWED_LIGHTS unshadowed_lights
#define LAMP_SHAPES lamp_shapes
#include "renderer/methods/image_space_photon_mapping/soft_shadows.glsl"

/// By what the pixels about it have; false: it is lit itself, or not at all.
bool upsampled(uint pixel, uint x, uint y, GBufferPoint point, out vec3 light) {
    const SplitRecord split = constants.split;
    light = vec3(0.0);
    if (!is_lit(point) || lights_itself(split, x, y, point, QUAD_HEIGHT * constants.radius_m)) return false;
    const SubSamples from = sub_samples_of(split, x, y, point, QUAD_HEIGHT * constants.radius_m);
    light = light_of_sub_samples(from);
    if (layer_kept(LAYER_UPSAMPLING_WEIGHT)) store_value(LAYER_UPSAMPLING_WEIGHT, pixel, from.total);
    return true;
}

void add_direct_light(uint pixel) {
    const UnshadowedLight light = unshadowed_lights[pixel];
    if (light.lamp == NO_LAMP) return;
    const SoftShadow shadow = soft_shadow(eye, pixel, light, shadow_samples, constants.turn);
    add_rgb(LAYER_DIRECT, pixel, shadow.seen * light.radiance);
    if (layer_kept(LAYER_SHADOW_DISTANCE)) store_value(LAYER_SHADOW_DISTANCE, pixel, shadow.occluder_m);
    if (layer_kept(LAYER_BLUR_RADIUS)) store_value(LAYER_BLUR_RADIUS, pixel, shadow.blur_pixels);
}

void main() {
    const uint pixel = flat_index();
    uint x, y, index;
    if (!split_place_of(constants.split, pixel, x, y, index)) return;
    const GBufferPoint point = points[index];
    vec3 light;
    const bool taken = (PARTS & COMBINE_UPSAMPLE) != 0u && upsampled(pixel, x, y, point, light);
    if ((PARTS & COMBINE_SHADOW) != 0u) add_direct_light(pixel);
    if ((PARTS & COMBINE_MERGE) != 0u) {
        if (point.kind != 0u) add_rgb(LAYER_INDIRECT, pixel, point.weight * (taken ? light : sums[index]));
    } else if (taken) {
        sums[index] = light;
    }
}

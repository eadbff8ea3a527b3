#version 460
// Brings what the splats left at the visible points into the image, a thread a pixel: CPU twin
// PhotonSplatting::light_image().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/frame/device_image.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/gbuffer/receiver.glsl"

layout(constant_id = SPLAT_NORMALISED_ID) const bool SPLAT_NORMALISED = false;
layout(constant_id = SPLAT_EDGES_ID) const bool SPLAT_EDGES = false;

layout(local_size_x = SPLAT_GROUP) in;
layout(push_constant, scalar) uniform Push { uint pixels; } push;
layout(set = 0, binding = 1, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Heads { uint first_of_pixel[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Points { SplatPoint points[]; };
layout(set = 0, binding = 4, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Sums { SplatSum sums[]; };
layout(set = 0, binding = 6, scalar) readonly buffer Eye { EyeConstants eye; };
layout(set = 0, binding = 7, scalar) writeonly buffer Edges { vec4 edges[]; };  // SPLAT_EDGES: a pixel's normal and depth

void main() {
    const uint pixel = flat_index();
    if (pixel >= push.pixels) return;
    vec3 indirect = vec3(0.0);
    float splats = 0.0;
    vec4 edge = vec4(vec3(0.0), INFINITY);
    for (uint index = first_of_pixel[pixel]; index != NO_POINT; index = points[index].next) {
        const SplatPoint point = points[index];
        const SplatSum sum = sums[index];
        vec3 light = sum.sum;
        if (SPLAT_NORMALISED) light *= sum.splat_weight > 0.0 ? constants.exposure / sum.splat_weight : 0.0;
        if (constants.ambient > 0.0 && sum.splats == 0.0) {
            const bool general = !ONLY_LAMBERT && (point.kind & POINT_GENERAL) != 0u;
            vec3 reflected = vec3(PI);
            if (general) reflected = bsdf_albedo(make_receiver(general_points[index], constants.glossy_threshold).rough);
            light += constants.ambient * reflected;
        }
        indirect += point.weight * light;
        splats += sum.splats;
        edge = vec4(point.normal, dot(point.position - eye.camera.position, eye.camera.forward));
    }
    if (SPLAT_EDGES) edges[pixel] = edge;
    add_rgb(LAYER_INDIRECT, pixel, indirect);
    if (layer_kept(LAYER_OVERLAP)) store_value(LAYER_OVERLAP, pixel, splats);
}

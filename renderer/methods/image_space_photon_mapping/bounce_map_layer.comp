#version 460
// How many texels of the bounce map lie in each pixel, a thread a texel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/methods/image_space_photon_mapping/photon_combine_shared.h"
#include "renderer/photons/photon_tracing_shared.h"
#include "renderer/transport/surface.glsl"

layout(local_size_x = PHOTON_TRACING_GROUP) in;
layout(push_constant, scalar) uniform Push { BounceMapLayerPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Eye { EyeConstants eye; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer FirstHits { FirstHit first_hits[]; };
#define SHOWN_POINTS points
#include "renderer/gbuffer/shown_places.glsl"
#define IMAGE_BINDING 0
#include "renderer/frame/count_in_layer.glsl"

void main() {
    const uint texel = flat_index();
    if (texel >= push.texels) return;
    const FirstHit from = first_hits[texel];
    const Hit hit = Hit(from.t, from.instance, from.triangle, from.u, from.v);
    if (!hit_valid(hit) || from.power_w == vec3(0.0)) return;
    uint pixel;
    const float kDepthShare = 0.01;
    if (pixel_that_shows(eye, push.split, make_shading_point(hit, from.ray_direction).position, kDepthShare, pixel))
        count_in_layer(LAYER_BOUNCE_MAP, pixel);
}

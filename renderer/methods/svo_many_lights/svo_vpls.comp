#version 460
// How many lights lie in each pixel, a thread a light: CPU twin show_vpls().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/split_shared.h"
#include "renderer/eye/eye_shared.h"
#include "renderer/many_lights/vpl_set_shared.h"

layout(local_size_x = VPL_SET_GROUP) in;
layout(push_constant, scalar) uniform Push { SplitRecord split; };
layout(set = 0, binding = 1, scalar) readonly buffer Eye { EyeConstants eye; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Counts { uint counts[VPL_COUNT_WORDS]; };
layout(set = 0, binding = 4, scalar) readonly buffer Vpls { Vpl vpls[]; };

#define SHOWN_POINTS points
#include "renderer/gbuffer/shown_places.glsl"
#define IMAGE_BINDING 0
#include "renderer/frame/count_in_layer.glsl"

void main() {
    const uint light = flat_index();
    if (light >= counts[VPL_COUNT]) return;
    uint pixel;
    if (pixel_that_shows(eye, split, vpls[light].position, VPL_SHOWN_DEPTH, pixel))
        count_in_layer(LAYER_VPLS, pixel);
}

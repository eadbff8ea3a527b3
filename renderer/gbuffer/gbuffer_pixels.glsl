// A thread a pixel of a split buffer that was lit: what its shaders read and the image that they write to.
#ifndef PHOTOND_GBUFFER_PIXELS_GLSL
#define PHOTOND_GBUFFER_PIXELS_GLSL

#define IMAGE_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/gbuffer/gbuffer_walk_shared.h"
#include "renderer/frame/device_image.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { SplitRecord split; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Sums { vec3 sums[]; };

/// False past the last pixel.
bool pixel_of_thread(out uint pixel) {
    pixel = flat_index();
    return pixel < split.width * split.height;
}

#endif

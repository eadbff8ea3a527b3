// The pass's layers, written by the thread that has the pixel. Define IMAGE_BINDING (of set 0) before, and COUNTERS_BINDING
// where the shader counts (counters.glsl). Host side: device_image.h.
#ifndef PHOTOND_DEVICE_IMAGE_GLSL
#define PHOTOND_DEVICE_IMAGE_GLSL

#include "renderer/frame/device_image_shared.h"
#ifdef COUNTERS_BINDING
#include "renderer/backends/gpu/counters.glsl"
#endif

layout(constant_id = PLANE_HIT_ID) const uint PLANE_HIT = NO_PLANE;
layout(constant_id = PLANES_ID) const uint PLANES = 1;

layout(set = 0, binding = IMAGE_BINDING, scalar) buffer DeviceLayers { float device_layers[]; };

// Not a constant: a pipeline is compiled once for images of all sizes.
uint film_pixels() { return uint(device_layers.length()) / PLANES; }

bool layer_kept(uint plane) { return plane != NO_PLANE; }

vec3 load_rgb(uint plane, uint pixel) {
    const uint i = plane * film_pixels() + 3 * pixel;
    return vec3(device_layers[i], device_layers[i + 1], device_layers[i + 2]);
}
void store_rgb(uint plane, uint pixel, vec3 value) {
    const uint i = plane * film_pixels() + 3 * pixel;
    device_layers[i] = value.x, device_layers[i + 1] = value.y, device_layers[i + 2] = value.z;
}
void add_rgb(uint plane, uint pixel, vec3 value) { store_rgb(plane, pixel, load_rgb(plane, pixel) + value); }
void store_value(uint plane, uint pixel, float value) { device_layers[plane * film_pixels() + pixel] = value; }
float load_value(uint plane, uint pixel) { return device_layers[plane * film_pixels() + pixel]; }

#endif

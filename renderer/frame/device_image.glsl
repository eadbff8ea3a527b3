// The pass's layers, written by the thread that has the pixel. Define IMAGE_BINDING (of set 0) before, and COUNTERS_BINDING
// where the shader counts (counters.glsl). Host side: device_image.h.
#ifndef PHOTOND_DEVICE_IMAGE_GLSL
#define PHOTOND_DEVICE_IMAGE_GLSL

#include "renderer/frame/device_image_shared.h"
#ifdef COUNTERS_BINDING
#include "renderer/backends/gpu/counters.glsl"
#endif

layout(set = 0, binding = IMAGE_BINDING, scalar) buffer DeviceLayers { uint device_layers[]; };

bool layer_kept(uint layer) { return device_layers[layer] != 0u; }

// Of a layer that is kept; emitted, direct and indirect always are.
uint rgb_place(uint layer, uint pixel) { return device_layers[layer] + 3 * pixel; }
uint value_place(uint layer, uint pixel) { return device_layers[layer] + pixel; }

vec3 load_rgb(uint layer, uint pixel) {
    const uint i = rgb_place(layer, pixel);
    return uintBitsToFloat(uvec3(device_layers[i], device_layers[i + 1], device_layers[i + 2]));
}
void store_rgb(uint layer, uint pixel, vec3 value) {
    const uint i = rgb_place(layer, pixel);
    const uvec3 words = floatBitsToUint(value);
    device_layers[i] = words.x, device_layers[i + 1] = words.y, device_layers[i + 2] = words.z;
}
void add_rgb(uint layer, uint pixel, vec3 value) { store_rgb(layer, pixel, load_rgb(layer, pixel) + value); }
void store_value(uint layer, uint pixel, float value) {
    device_layers[value_place(layer, pixel)] = floatBitsToUint(value);
}
float load_value(uint layer, uint pixel) { return uintBitsToFloat(device_layers[value_place(layer, pixel)]); }

#endif

// The pass's layers and counters, written by the thread that has the pixel. Define IMAGE_BINDING and COUNTERS_BINDING (of
// set 0) before. Host side: device_image.h.
#ifndef PHOTOND_DEVICE_IMAGE_GLSL
#define PHOTOND_DEVICE_IMAGE_GLSL

#include "renderer/methods/device_image_shared.h"

layout(constant_id = PLANE_CAUSTIC_ID) const uint PLANE_CAUSTIC = NO_PLANE;
layout(constant_id = PLANE_ALBEDO_ID) const uint PLANE_ALBEDO = NO_PLANE;
layout(constant_id = PLANE_NORMAL_ID) const uint PLANE_NORMAL = NO_PLANE;
layout(constant_id = PLANE_POSITION_ID) const uint PLANE_POSITION = NO_PLANE;
layout(constant_id = PLANE_DEPTH_ID) const uint PLANE_DEPTH = NO_PLANE;
layout(constant_id = PLANE_PHOTON_COUNT_ID) const uint PLANE_PHOTON_COUNT = NO_PLANE;
layout(constant_id = PLANE_OVERLAP_ID) const uint PLANE_OVERLAP = NO_PLANE;
layout(constant_id = PLANE_HIT_ID) const uint PLANE_HIT = NO_PLANE;
layout(constant_id = FILM_PIXELS_ID) const uint FILM_PIXELS = 1;

layout(set = 0, binding = IMAGE_BINDING, scalar) buffer DeviceLayers { float device_layers[]; };

bool layer_kept(uint plane) { return plane != NO_PLANE; }

vec3 load_rgb(uint plane, uint pixel) {
    const uint i = plane * FILM_PIXELS + 3 * pixel;
    return vec3(device_layers[i], device_layers[i + 1], device_layers[i + 2]);
}
void store_rgb(uint plane, uint pixel, vec3 value) {
    const uint i = plane * FILM_PIXELS + 3 * pixel;
    device_layers[i] = value.x, device_layers[i + 1] = value.y, device_layers[i + 2] = value.z;
}
void add_rgb(uint plane, uint pixel, vec3 value) { store_rgb(plane, pixel, load_rgb(plane, pixel) + value); }
void store_value(uint plane, uint pixel, float value) { device_layers[plane * FILM_PIXELS + pixel] = value; }
float load_value(uint plane, uint pixel) { return device_layers[plane * FILM_PIXELS + pixel]; }

#ifdef COUNTERS_BINDING
layout(set = 0, binding = COUNTERS_BINDING, scalar) buffer DeviceCounters { uint device_counters[]; };

shared uint counted[COUNTERS];

/// Called by all threads of a group, before anything else ...
void start_counting() {
    if (gl_LocalInvocationIndex < COUNTERS) counted[gl_LocalInvocationIndex] = 0;
    barrier();
}
/// ... by those that have something to count ...
void count(uint counter, uint n) {
    if (n > 0) atomicAdd(counted[counter], n);
}
/// ... and by all of them, last.
void finish_counting() {
    barrier();
    const uint counter = gl_LocalInvocationIndex;
    if (counter >= COUNTERS || counted[counter] == 0) return;
    const uint before = atomicAdd(device_counters[2 * counter], counted[counter]);
    if (before + counted[counter] < before) atomicAdd(device_counters[2 * counter + 1], 1u);  // the carry
}
#endif

#endif

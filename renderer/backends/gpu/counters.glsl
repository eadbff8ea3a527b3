// What a shader counts, group by group. Define COUNTERS_BINDING (of set 0) before. Host side: counters.h.
#ifndef PHOTOND_COUNTERS_GLSL
#define PHOTOND_COUNTERS_GLSL

#include "renderer/backends/gpu/counters_shared.h"

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

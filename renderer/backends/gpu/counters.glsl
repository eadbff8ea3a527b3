// What a shader counts. Define COUNTERS_BINDING (of set 0) before. Host side: counters.h.
//
// No barriers: lavapipe compiles shaders that have one as coroutines, for a multiple of the time.
#ifndef PHOTOND_COUNTERS_GLSL
#define PHOTOND_COUNTERS_GLSL

#extension GL_KHR_shader_subgroup_arithmetic : require

#include "renderer/backends/gpu/counters_shared.h"

layout(set = 0, binding = COUNTERS_BINDING, scalar) buffer DeviceCounters { uint device_counters[]; };

/// Adds n: one atomic operation for the threads of a subgroup that count together.
void count(uint counter, uint n) {
    const uint sum = subgroupAdd(n);
    if (!subgroupElect() || sum == 0) return;
    const uint before = atomicAdd(device_counters[2 * counter], sum);
    if (before + sum < before) atomicAdd(device_counters[2 * counter + 1], 1u);  // the carry
}

#endif

// Sums over the threads of a workgroup, for groups of WARPS warps of WARP threads each.
//
// A warp here is WARP threads that keep in step by warp_barrier(). Where the host knows that a subgroup holds whole
// warps (group_sum.h) and the compiled shader finds it so, that is the subgroup's barrier, else the workgroup's: right
// for any size of subgroup, cheap where subgroups are as wide as warps.
#ifndef PHOTOND_GROUP_SUM_GLSL
#define PHOTOND_GROUP_SUM_GLSL

#extension GL_KHR_shader_subgroup_basic : require
#include "renderer/backends/gpu/group_sum_shared.h"

layout(local_size_x_id = GROUP_SIZE_CONSTANT) in;
layout(constant_id = WARP_CONSTANT) const uint WARP = 32;
layout(constant_id = WARPS_IN_SUBGROUPS_CONSTANT) const bool WARPS_IN_SUBGROUPS = false;
const uint GROUP = gl_WorkGroupSize.x;
const uint TILE = GROUP * TILE_ITEMS;

bool warps_in_subgroups() {
    return WARPS_IN_SUBGROUPS && gl_SubgroupSize % WARP == 0 && gl_NumSubgroups * gl_SubgroupSize == GROUP;
}

/// This thread's place in the group; threads of a warp are neighbours.
uint group_thread() {
    return warps_in_subgroups() ? gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID : gl_LocalInvocationIndex;
}

/// What the warp's threads wrote to shared memory before, they all see after. All threads of the group must come here.
void warp_barrier() {
    if (warps_in_subgroups())
        subgroupBarrier();
    else
        barrier();
}

shared uint group_words[MOST_GROUP_THREADS];
shared uint group_warps[WARPS];

/// The sum of `x` over the threads before this one; `total`: over all threads of the group. All must come here.
uint group_exclusive_sum(uint x, out uint total) {
    const uint thread = group_thread(), lane = thread % WARP, warp = thread / WARP;
    uint sum = x;
    for (uint step = 1; step < WARP; step *= 2) {  // [Hillis and Steele 1986] within a warp
        group_words[thread] = sum;
        warp_barrier();
        if (lane >= step) sum += group_words[thread - step];
        warp_barrier();
    }
    if (lane == WARP - 1) group_warps[warp] = sum;
    barrier();
    uint before = 0;
    total = 0;
    for (uint i = 0; i < WARPS; ++i) {
        if (i == warp) before = total;
        total += group_warps[i];
    }
    barrier();  // shared memory is free for the next sum
    return before + sum - x;
}

#endif

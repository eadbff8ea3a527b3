// Exclusive sums over as many elements as there are, in the dispatch that makes them: each group sums its own, and the
// group that ends last sums the groups' sums. No group waits for another. The sum before element i is what its group
// has before it, plus group_starts[i / GROUP]. Define SVO_GROUP_STARTS_BINDING (of set 0) before.
//
// The way of the threadFenceReduction sample [NVIDIA, CUDA samples].
#ifndef PHOTOND_SVO_SUMS_GLSL
#define PHOTOND_SVO_SUMS_GLSL

#include "renderer/backends/gpu/group_sum.glsl"
#include "renderer/voxels/svo_build.glsl"

layout(set = 0, binding = SVO_GROUP_STARTS_BINDING, scalar) coherent buffer GroupStarts { uint group_starts[]; };

shared bool group_is_last;
shared bool sums_wrap;  // for the last group: some sum is more than 32 bits hold

uint group_number() { return flat_index() / GROUP; }
/// Groups that this many elements take.
uint sum_groups(uint elements) { return groups_of(elements, GROUP); }

/// Ends a group's part; all threads of each of the groups must come here. True in the group that ends last: it finds
/// what all of them wrote to coherent buffers before, the starts in place, and the sum of all.
bool end_sums(uint groups, uint group_sum, out uint sum_of_all) {
    const uint thread = group_thread();
    sum_of_all = 0u;
    if (thread == 0u) group_starts[group_number()] = group_sum;
    memoryBarrierBuffer();
    barrier();
    if (thread == 0u) {
        group_is_last = atomicAdd(state.ended_groups, 1u) == groups - 1u;
        sums_wrap = false;
    }
    barrier();
    if (!group_is_last) return false;
    memoryBarrierBuffer();
    for (uint first = 0u; first < groups; first += GROUP) {
        const uint i = first + thread, sum = i < groups ? group_starts[i] : 0u;
        uint total;
        const uint start = sum_of_all + group_exclusive_sum(sum, total);
        if (i < groups) group_starts[i] = start;
        if (start < sum_of_all || start + sum < start) sums_wrap = true;
        sum_of_all += total;
    }
    if (thread == 0u) state.ended_groups = 0u;
    memoryBarrierBuffer();
    barrier();
    return true;
}

#endif

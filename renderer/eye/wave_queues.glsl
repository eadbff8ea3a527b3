// The queues of a wavefront: paths stay in their places, and queues hold the places of those under way. Which path is
// where in a queue differs from run to run. Define WAVE_QUEUES_BINDING (of set 0) before.
#ifndef PHOTOND_WAVE_QUEUES_GLSL
#define PHOTOND_WAVE_QUEUES_GLSL

#extension GL_KHR_shader_subgroup_ballot : require

#include "renderer/eye/wave_queues_shared.h"

layout(set = 0, binding = WAVE_QUEUES_BINDING, scalar) buffer WaveQueues {
    uint wave_queues[];  // the counts, then two queues of paths, each as long as there is room for paths
};

/// A place among those that come next: one atomic operation for the threads of a subgroup that ask together.
uint take_place(uint queue) {
    const uvec4 asking = subgroupBallot(true);
    uint first = 0;
    if (subgroupElect()) first = atomicAdd(wave_queues[WAVE_NEXT(queue)], subgroupBallotBitCount(asking));
    return subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(asking);
}

#endif

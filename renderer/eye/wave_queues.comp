#version 460
// Between a wavefront's kernels, one thread: what waits next is what is there now, and how many groups that takes.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define WAVE_QUEUES_BINDING 0
#include "renderer/eye/wave_queues.glsl"

layout(local_size_x = 1) in;

/// Rows of groups, as flat_index() counts them: one dimension holds only so many.
void set_groups(uint at, uint threads) {
    const uint kRow = 1u << 15;
    const uint groups = (threads + WAVE_GROUP - 1) / WAVE_GROUP;
    wave_queues[at] = min(groups, kRow);
    wave_queues[at + 1] = (groups + kRow - 1) / kRow;
    wave_queues[at + 2] = 1;
}

void main() {
    for (uint queue = 0; queue < WAVE_QUEUES; ++queue) {
        const uint waiting = wave_queues[WAVE_NEXT(queue)];
        wave_queues[WAVE_NOW(queue)] = waiting;
        wave_queues[WAVE_NEXT(queue)] = 0;
        set_groups(WAVE_GROUPS(queue), waiting);
    }
}

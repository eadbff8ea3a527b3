#version 460
// Between the wavefront's kernels, one thread: what waits next is what is there now, and how many groups that takes.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/path_tracing/path_tracing_shared.h"

layout(local_size_x = 1) in;
layout(set = 0, binding = 0, scalar) buffer PathCounts { uint path_counts[]; };

/// Rows of groups, as flat_index() counts them: one dimension holds only so many.
void set_groups(uint at, uint threads) {
    const uint kRow = 1u << 15;
    const uint groups = (threads + PATH_QUEUE_GROUP - 1) / PATH_QUEUE_GROUP;
    path_counts[at] = min(groups, kRow);
    path_counts[at + 1] = (groups + kRow - 1) / kRow;
    path_counts[at + 2] = 1;
}

void main() {
    path_counts[PATHS_NOW] = path_counts[PATHS_NEXT];
    path_counts[SHADOWS_NOW] = path_counts[SHADOWS_NEXT];
    path_counts[PATHS_NEXT] = 0;
    path_counts[SHADOWS_NEXT] = 0;
    set_groups(PATH_GROUPS, path_counts[PATHS_NOW]);
    set_groups(SHADOW_GROUPS, path_counts[SHADOWS_NOW]);
}

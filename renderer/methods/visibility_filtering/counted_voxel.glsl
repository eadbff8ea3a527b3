// A voxel that a ray of a list has met, in the list. Define VISIBILITY (the VisibilityConstants) and LISTS, and the buffer
// `lists`, before, and include met_voxel.glsl.
#ifndef PHOTOND_COUNTED_VOXEL_GLSL
#define PHOTOND_COUNTED_VOXEL_GLSL

void count_voxel(uint list, MetVoxel met) {
    const uint first = list * VISIBILITY.words;
    if (LISTS == LISTS_COUNTS)
        atomicAdd(lists[first + 2u * met.slot], met.where_lit ? 1u : 1u << 16);
    else
        atomicOr(lists[first + met.slot / 32], 1u << met.slot % 32);
}

#endif

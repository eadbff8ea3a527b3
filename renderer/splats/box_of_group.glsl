// The box of what the threads of a group have, each a box of its own. Define BOX_GROUP (threads of the group) before.
#ifndef PHOTOND_BOX_OF_GROUP_GLSL
#define PHOTOND_BOX_OF_GROUP_GLSL

shared vec3 group_low[BOX_GROUP], group_high[BOX_GROUP];

/// For all threads alike; `low` above `high`: nothing.
void box_of_group(inout vec3 low, inout vec3 high) {
    const uint thread = gl_LocalInvocationIndex;
    group_low[thread] = low, group_high[thread] = high;
    barrier();
    for (uint step = BOX_GROUP / 2; step > 0; step /= 2) {
        if (thread < step) {
            group_low[thread] = min(group_low[thread], group_low[thread + step]);
            group_high[thread] = max(group_high[thread], group_high[thread + step]);
        }
        barrier();
    }
    low = group_low[0], high = group_high[0];
}

#endif

// Which thread this is, of CommandList::dispatch_threads(): rows of groups, as one dimension holds only so many.
#ifndef PHOTOND_INVOCATION_GLSL
#define PHOTOND_INVOCATION_GLSL

uint flat_index() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}

#endif

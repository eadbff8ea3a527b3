// Which thread this is, of CommandList::dispatch_threads(): rows of groups, as one dimension holds only so many.
#ifndef PHOTOND_INVOCATION_GLSL
#define PHOTOND_INVOCATION_GLSL

// This is a macro because a function that stands before `layout(local_size_x = ...) in` would read 1 as
// gl_WorkGroupSize, and the compiler would not say so.
#define flat_index() \
    ((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex)

#endif

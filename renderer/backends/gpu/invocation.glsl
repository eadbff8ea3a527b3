// Which thread this is, of CommandList::dispatch_threads(): rows of groups, as one dimension holds only so many.
#ifndef PHOTOND_INVOCATION_GLSL
#define PHOTOND_INVOCATION_GLSL

// Not a function: in one that stands before `layout(local_size_x = ...) in`, gl_WorkGroupSize is 1 without a word from
// the compiler.
#define flat_index() \
    ((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex)

#endif

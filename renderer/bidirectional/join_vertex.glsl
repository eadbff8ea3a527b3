// A vertex of the eye's path that is to be joined with light paths. Define what bidirectional.glsl and joined_light.glsl
// want, and EYE_BINDING (of set 0), before.
#ifndef PHOTOND_JOIN_VERTEX_GLSL
#define PHOTOND_JOIN_VERTEX_GLSL

#include "renderer/bidirectional/bidirectional.glsl"
#include "renderer/bidirectional/joined_light.glsl"

/// A surface vertex of the eye's path with lobes that are no delta, as the path arrived there.
struct JoinVertex {
    EyePath path;
    SubpathWeights weights;
    SurfaceVertex surface;
    float outside_ior;
    float acceptance;  // merge_acceptance() of its place
};

#endif

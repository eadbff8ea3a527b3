// How many proxies a triangle has, in a pass: its area times the density, rounded up or down by a hash of its place, so
// that surfaces that move take their proxies with them. Define PROXY_PUSH (a ProxyPush) before.
#ifndef PHOTOND_PROXY_TRIANGLES_GLSL
#define PHOTOND_PROXY_TRIANGLES_GLSL

#include "renderer/core/rng.glsl"
#include "renderer/backends/gpu/scene.glsl"
#include "renderer/voxels/svo_triangles.glsl"

/// Of a triangle in a pass: what its random numbers are drawn by.
uint proxy_key(TriangleCorners at) {
    const vec3 middle = (at.p[0] + at.p[1] + at.p[2]) / 3.0;
    uint key = uint(PROXY_PUSH.seed ^ PROXY_PUSH.seed >> 32) ^ hash32(PROXY_PUSH.pass);
    for (int axis = 0; axis < 3; ++axis) key = hash32(key ^ floatBitsToUint(middle[axis]));
    return key;
}

#endif

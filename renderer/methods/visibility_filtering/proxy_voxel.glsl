// What is seen of a voxel's proxies all together.
#ifndef PHOTOND_PROXY_VOXEL_GLSL
#define PHOTOND_PROXY_VOXEL_GLSL

#include "renderer/methods/visibility_filtering/point_proxies_shared.h"

/// The area of its surface, times the cosine there, towards a point in that direction: of proxies with light on their lit
/// side, of others on both. By harmonics of order 1.
float area_seen(ProxyVoxel voxel, vec3 from_point) {
    return max(0.25 * voxel.lit_m2 - 0.5 * dot(voxel.lit_normal_m2, from_point), 0.0) + 0.5 * voxel.dark_m2;
}

#endif

// Proxies by their words, and what is seen of a voxel's all together.
#ifndef PHOTOND_PROXY_VOXEL_GLSL
#define PHOTOND_PROXY_VOXEL_GLSL

#include "renderer/methods/visibility_filtering/point_proxies_shared.h"
#include "renderer/photons/photon.glsl"

uint proxy_word(vec3 normal, bool is_lit_one) {
    return octahedral_encode(PROXY_NORMAL_BITS, normal) | (is_lit_one ? PROXY_LIT : 0u);
}
vec3 proxy_normal(uint word) { return octahedral_decode(PROXY_NORMAL_BITS, word); }
bool proxy_is_lit(uint word) { return (word & PROXY_LIT) != 0u; }

/// The areas with light and without of its surface, times the cosine there, towards a point in the opposite of that
/// direction: of proxies with light on their lit side, of others on both. By harmonics of order 1.
vec2 area_seen(ProxyVoxel voxel, vec3 from_point) {
    return vec2(max(0.25 * voxel.lit_m2 - 0.5 * dot(voxel.lit_normal_m2, from_point), 0.0), 0.5 * voxel.dark_m2);
}

#endif

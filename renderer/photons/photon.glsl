// GLSL twin of photons/photon.h: the photon's record and its unit vectors in few bits.
#ifndef PHOTOND_PHOTON_GLSL
#define PHOTOND_PHOTON_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/photons/photon_shared.h"

uint octahedral_mask(uint bits) { return (1u << bits) - 1u; }

/// Octahedral<bits>::encode: a unit vector in 2 x `bits` bits.
uint octahedral_encode(uint bits, vec3 n) {
    const float scale = 1.0 / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 p = n.xy * scale;
    if (n.z < 0.0) p = vec2(copysign(1.0 - abs(p.y), p.x), copysign(1.0 - abs(p.x), p.y));
    const float half_codes = 0.5 * float(octahedral_mask(bits) - 1u);
    const uvec2 code = uvec2(p * half_codes + (half_codes + 0.5));
    return code.x | code.y << bits;
}
vec3 octahedral_decode(uint bits, uint codes) {
    const uint mask = octahedral_mask(bits);
    const vec2 p = 2.0 * vec2(codes & mask, codes >> bits & mask) / float(mask - 1u) - 1.0;
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (n.z < 0.0) n.xy = vec2(copysign(1.0 - abs(p.y), p.x), copysign(1.0 - abs(p.x), p.y));
    return n * (1.0 / sqrt(dot(n, n)));
}

// PhotonPayload::normal_and_path. `normal`: geometric, on the side the photon arrived at.
uint pack_normal_and_path(vec3 normal, uint scatterings, bool all_delta, bool marked) {
    const uint path =
        min(scatterings, PHOTON_MOST_SCATTERINGS) | (all_delta ? 1u << 8 : 0u) | (marked ? 1u << 9 : 0u);
    return octahedral_encode(11u, normal) | path << 22;
}
vec3 photon_normal(uint normal_and_path) { return octahedral_decode(11u, normal_and_path); }
uint photon_scatterings(uint normal_and_path) { return normal_and_path >> 22 & 0xffu; }
bool photon_all_delta(uint normal_and_path) { return (normal_and_path >> 30 & 1u) != 0u; }
bool photon_marked(uint normal_and_path) { return normal_and_path >> 31 != 0u; }

/// is_marked_photon() of photon.h; `element`: its low 32 bits.
bool is_marked_photon(uint element, uint scatterings) {
    return hash32(hash32(element) + scatterings) % PHOTONS_A_MARK == 0u;
}

uint pack_photon_direction(vec3 wi_world) { return octahedral_encode(16u, wi_world); }
vec3 photon_direction(uint direction) { return octahedral_decode(16u, direction); }

#endif

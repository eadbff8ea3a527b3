#pragma once
// Virtual point lights made up for tests, and what one brings, written down plainly.

#include <vector>

#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/photons/photon.h"

namespace photond::test {

inline vec3 random_direction(RandomStream& random) {
    for (;;) {
        const vec3 p = 2.0f * vec3(random.next(), random.next(), random.next()) - 1.0f;
        const float length_sq = glm::dot(p, p);
        if (length_sq > 1e-4f && length_sq <= 1) return p / std::sqrt(length_sq);
    }
}

/// Lambert but for a share of them, within 5 m of each other along each axis, clustered; some of corrected normals.
inline std::vector<Vpl> random_vpls(uint32_t count, uint64_t seed, float others) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    std::vector<Vpl> vpls(count);
    for (Vpl& vpl : vpls) {
        const bool lambert = random.next() >= others;
        vpl.position = 5.0f * (vec3(random.next(), random.next(), random.next()) - 0.5f);
        if (random.next() < 0.5f) vpl.position.y = -2.5f;  // a floor
        vpl.normal = vpl.position.y == -2.5f ? vec3(0, 1, 0) : random_direction(random);
        vpl.smooth_normal = Octahedral<16>::encode(glm::normalize(vpl.normal + 0.5f * random_direction(random)));
        vpl.correction = lambert && random.next() < 0.3f ? 0.5f + random.next() : 1.0f;
        vpl.intensity = Rgb(random.next(), random.next(), random.next()) * (random.next() < 0.1f ? 10.0f : 1.0f);
        vpl.surface = lambert ? NO_VPL_SURFACE : 0;
        vpl.scatterings = 1 + static_cast<uint32_t>(random.next() * 2);
    }
    return vpls;
}

/// Lambert lights on the floor y = 0, facing up.
inline std::vector<Vpl> on_one_wall(uint32_t count, uint64_t seed) {
    std::vector<Vpl> vpls = random_vpls(count, seed, 0);
    for (Vpl& vpl : vpls) vpl.position.y = 0, vpl.normal = vec3(0, 1, 0), vpl.correction = 1;
    return vpls;
}

/// What a Lambert light brings to a point unshadowed [W m^-2]; normal 0: from all sides.
inline Rgb exact_irradiance(const Vpl& vpl, const vec3& position, const vec3& normal, float clamp_sq_m2) {
    const vec3 d = position - vpl.position;
    const float distance = glm::length(d);
    if (!(distance > 0)) return Rgb(0);
    const vec3 w = d / distance;
    const float sent = std::max(glm::dot(vpl.normal, w), 0.0f);
    const float received = normal == vec3(0) ? 1.0f : std::max(-glm::dot(normal, w), 0.0f);
    const float correction = glm::dot(Octahedral<16>::decode(vpl.smooth_normal), w) > 0 ? vpl.correction : 1.0f;
    return vpl.intensity * (sent * received * correction * clamped_falloff(distance * distance, clamp_sq_m2));
}

}  // namespace photond::test

#pragma once
// Environments made in code, for what is lit by them.

#include <cmath>

#include "renderer/scene/scene.h"

namespace photond::test {

/// Radiance by direction, from `radiance(direction)` at the texels' centres, whole turn unless `rotation` is set after.
template <class Radiance>
Environment environment_of(Size2 size, const Radiance& radiance) {
    Environment environment;
    environment.map.size = size;
    environment.map.radiance.reserve(size.pixels());
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) {
            const float polar = kPi * (static_cast<float>(y) + 0.5f) / static_cast<float>(size.height);
            const float azimuth = 2 * kPi * ((static_cast<float>(x) + 0.5f) / static_cast<float>(size.width) - 0.5f);
            environment.map.radiance.push_back(radiance(
                vec3(std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth))));
        }
    return environment;
}

inline Environment even_environment(const Rgb& radiance) {
    return environment_of({8, 4}, [&](const vec3&) { return radiance; });
}

/// Blue above, brown below.
inline Rgb sky_radiance(const vec3& direction) {
    return direction.y > 0 ? glm::mix(Rgb(0.9f, 0.95f, 1), Rgb(0.2f, 0.4f, 0.9f), direction.y)
                           : glm::mix(Rgb(0.9f, 0.95f, 1), Rgb(0.25f, 0.2f, 0.15f), std::min(-4 * direction.y, 1.0f));
}
inline Environment sky(Size2 size) { return environment_of(size, sky_radiance); }

/// With a sun of `sun_radius` radians that brings about as much as the sky, 40 degrees up.
inline Environment sky_with_sun(Size2 size, float sun_radius = 0.05f) {
    const vec3 sun = glm::normalize(vec3(0.6f, 0.64f, -0.47f));
    const float radiance = 2 / (sun_radius * sun_radius);
    return environment_of(size, [&](const vec3& direction) {
        const float angle = std::acos(std::clamp(glm::dot(direction, sun), -1.0f, 1.0f));
        return sky_radiance(direction) + (angle < sun_radius ? radiance * Rgb(1, 0.9f, 0.7f) : Rgb(0));
    });
}

/// A dark room with three bright windows and a dim floor.
inline Environment windows(Size2 size) {
    return environment_of(size, [](const vec3& d) {
        const float turn = std::atan2(d.z, d.x);
        const bool window = std::fabs(d.y - 0.25f) < 0.2f && std::fmod(turn + 2 * kPi, 2 * kPi / 3) < 0.5f;
        return window ? Rgb(6, 6.5f, 7) : d.y < -0.2f ? Rgb(0.3f, 0.25f, 0.2f) : Rgb(0.1f);
    });
}

}  // namespace photond::test

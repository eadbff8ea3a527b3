#pragma once
// G-buffers made by hand, in the order of a split layout.

#include <vector>

#include "renderer/core/rng.h"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/split_buffer.h"

namespace photond::test {

/// Padding and pixels without a point are zero.
struct SplitImage {
    SplitImage(Size2 size, uint32_t side)
        : layout(size, side), points(layout.points(), gpu::GBufferPoint{}), irradiance(layout.points(), vec3(0)) {}

    gpu::GBufferPoint& point(uint32_t x, uint32_t y) { return points[layout.point_of(x, y)]; }
    vec3& light(uint32_t x, uint32_t y) { return irradiance[layout.point_of(x, y)]; }

    SplitLayout layout;
    std::vector<gpu::GBufferPoint> points;
    std::vector<vec3> irradiance;
};

/// A plane z = 0 of unit pixels seen from straight above at depth 10, with random irradiance.
inline SplitImage flat_image(Size2 size, uint32_t side, uint64_t seed) {
    SplitImage image(size, side);
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    for (uint32_t y = 0; y < size.height; ++y) {
        for (uint32_t x = 0; x < size.width; ++x) {
            gpu::GBufferPoint& point = image.point(x, y);
            point.kind = GBUFFER_POINT;
            point.pixel = y * size.width + x;
            point.position = {x, y, 0};
            point.normal = point.geometric_normal = {0, 0, 1};
            point.depth_m = 10;
            image.light(x, y) = {random.next(), 3 * random.next(), 0.1f + random.next()};
        }
    }
    return image;
}

/// Bumps of a few tenths on it, normals that differ by up to a quarter, and of each ten pixels one without a point and
/// one that is not Lambert.
inline SplitImage rough_image(Size2 size, uint32_t side, uint64_t seed) {
    SplitImage image = flat_image(size, side, seed);
    RandomStream random(seed, RandomDomain::Test, 1, 0);
    for (uint32_t y = 0; y < size.height; ++y) {
        for (uint32_t x = 0; x < size.width; ++x) {
            gpu::GBufferPoint& point = image.point(x, y);
            const auto tilt = [&] {
                const vec2 u = 0.5f * random.next_2d() - 0.25f;
                return glm::normalize(vec3(u, 1));
            };
            point.position.z = 0.4f * random.next();
            point.normal = tilt();
            point.geometric_normal = tilt();
            point.depth_m = 9 + 2 * random.next();
            const float kind = random.next();
            if (kind < 0.1f) point.kind = 0;
            if (kind > 0.9f) point.kind |= GBUFFER_GENERAL;
        }
    }
    return image;
}

}  // namespace photond::test

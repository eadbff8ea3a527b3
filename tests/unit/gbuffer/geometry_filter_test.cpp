// The geometry-aware filter against a direct sum, and what it must keep: constants, edges, means of what is flat.

#include "renderer/gbuffer/geometry_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/support/gbuffer_parts.h"
#include "tests/support/threads.h"

namespace photond::geometry_filter_test {
namespace {

using test::SplitImage;

std::vector<vec3> filter(const SplitImage& image, const GeometryFilter& settings) {
    std::vector<vec3> filtered(image.points.size(), vec3(-1));
    filter_geometry_aware(image.layout, image.points, image.irradiance, settings, filtered);
    return filtered;
}

bool is_lambert(const gpu::GBufferPoint& point) {
    return (point.kind & GBUFFER_POINT) && !(point.kind & GBUFFER_GENERAL);
}

/// As the header states it, in double; `close`: a neighbour is within rounding of a limit.
dvec3 direct_mean(SplitImage& image, const GeometryFilter& settings, int x, int y, bool& close) {
    const gpu::GBufferPoint& here = image.point(uint32_t(x), uint32_t(y));
    const int width = int(settings.width);
    dvec3 sum(0);
    double count = 0;
    close = false;
    for (int j = y - width / 2; j < y - width / 2 + width; ++j) {
        for (int i = x - width / 2; i < x - width / 2 + width; ++i) {
            if (i < 0 || j < 0 || i >= int(image.layout.size.width) || j >= int(image.layout.size.height)) continue;
            const gpu::GBufferPoint& other = image.point(uint32_t(i), uint32_t(j));
            if (!is_lambert(other)) continue;
            const double cosine = glm::dot(dvec3(here.normal), dvec3(other.normal)) - double{settings.normal_cosine};
            const double height =
                std::abs(glm::dot(dvec3(here.geometric_normal), dvec3(other.position) - dvec3(here.position))) -
                double{settings.distance_relative} * double{here.depth_m};
            const bool self = i == x && j == y;
            if (!self && (std::abs(cosine) < 1e-6 || std::abs(height) < 1e-5)) close = true;
            if (!self && (cosine < 0 || height > 0)) continue;
            sum += dvec3(image.light(uint32_t(i), uint32_t(j)));
            count += 1;
        }
    }
    return sum / count;
}

TEST(GeometryFilter, IsTheDirectMean) {
    for (const Size2 size : {Size2{37, 23}, Size2{5, 3}, Size2{1, 20}, Size2{20, 1}, Size2{1, 1}}) {
        for (const uint32_t side : {1u, 3u, 4u}) {
            for (const uint32_t width : {3u, 4u, 8u, 17u}) {
                SplitImage image = test::rough_image(size, side, width);
                const GeometryFilter settings{width, 0.93f, 0.02f};
                const std::vector<vec3> filtered = filter(image, settings);
                size_t compared = 0, changed = 0, lambert = 0;
                for (uint32_t y = 0; y < size.height; ++y) {
                    for (uint32_t x = 0; x < size.width; ++x) {
                        const uint32_t point = image.layout.point_of(x, y);
                        if (!is_lambert(image.points[point])) {
                            ASSERT_EQ(filtered[point], image.irradiance[point]) << "passes through";
                            continue;
                        }
                        ++lambert;
                        bool close = false;
                        const dvec3 expected = direct_mean(image, settings, int(x), int(y), close);
                        if (close) continue;
                        ++compared;
                        changed += filtered[point] != image.irradiance[point] ? 1 : 0;
                        for (int c = 0; c < 3; ++c)
                            ASSERT_NEAR(filtered[point][c], expected[c], 2e-6)
                                << x << ", " << y << ", " << width << " across";
                    }
                }
                EXPECT_GE(10 * compared, 9 * lambert) << "few are too close to a limit to tell";
                if (size.pixels() > 100) {
                    EXPECT_GT(2 * changed, lambert) << "there is something to filter";
                }
            }
        }
    }
}

TEST(GeometryFilter, ConstantsStayWhateverTheGeometry) {
    SplitImage image = test::rough_image({61, 40}, 4, 1);
    const vec3 constant(0.1f, 1.7f, 31);
    for (vec3& c : image.irradiance) c = constant;
    for (const vec3& c : filter(image, {8, 0.9f, 0.02f}))
        for (int k = 0; k < 3; ++k) ASSERT_NEAR(c[k] / constant[k], 1, 2e-6);
}

// A wall that meets the floor, and a step of it: neither takes light from the other side.
TEST(GeometryFilter, EdgesStay) {
    constexpr Size2 kSize{40, 24};
    SplitImage image = test::flat_image(kSize, 4, 2);
    for (uint32_t y = 0; y < kSize.height; ++y) {
        for (uint32_t x = 0; x < kSize.width; ++x) {
            gpu::GBufferPoint& point = image.point(x, y);
            image.light(x, y) = vec3(1);
            if (x >= 20) {
                point.normal = point.geometric_normal = {-1, 0, 0};
                point.position = {20, y, x - 20};
                image.light(x, y) = vec3(5);
            } else if (y >= 12) {
                point.position.z = 0.5f;  // 5 percent of the depth
                image.light(x, y) = vec3(3);
            }
        }
    }
    for (const float distance : {0.02f, 0.06f}) {
        const std::vector<vec3> filtered = filter(image, {8, 0.9f, distance});
        for (uint32_t y = 0; y < kSize.height; ++y) {
            for (uint32_t x = 0; x < kSize.width; ++x) {
                const float light = filtered[image.layout.point_of(x, y)].x, own = image.light(x, y).x;
                if (x < 20 && distance > 0.05f && y > 8 && y < 16) {
                    EXPECT_TRUE(light > 1 && light < 3) << "a step below the limit is no edge: " << x << ", " << y;
                } else {
                    EXPECT_NEAR(light, own, 1e-6) << x << ", " << y;
                }
            }
        }
    }
}

TEST(GeometryFilter, KeepsTheMeanOfWhatIsFlatAndReachesAsFarAsItsWidth) {
    constexpr Size2 kSize{48, 40};
    for (const uint32_t width : {3u, 4u, 5u, 8u, 12u, 16u, 17u}) {
        SplitImage image = test::flat_image(kSize, 4, 3);
        for (vec3& light : image.irradiance) light = vec3(0);
        image.light(21, 19) = {1, 2, 4};
        const std::vector<vec3> filtered = filter(image, {width, 0.9f, 0.02f});
        dvec3 sum(0);
        const int before = int(width / 2), after = int(width) - 1 - before;
        for (int y = 0; y < int(kSize.height); ++y) {
            for (int x = 0; x < int(kSize.width); ++x) {
                const vec3 light = filtered[image.layout.point_of(uint32_t(x), uint32_t(y))];
                sum += dvec3(light);
                const bool within = 21 >= x - before && 21 <= x + after && 19 >= y - before && 19 <= y + after;
                EXPECT_EQ(light.x > 0, within) << x << ", " << y << ", " << width << " across";
            }
        }
        EXPECT_NEAR(sum.x, 1, 1e-6);
        EXPECT_NEAR(sum.y, 2, 2e-6);
        EXPECT_NEAR(sum.z, 4, 4e-6);
    }
}

// Each tile has a light of its own, as if its subset of the lights were all there are.
TEST(GeometryFilter, AMultipleOfTheInterleavingTakesEachSubsetAlike) {
    constexpr Size2 kSize{40, 36};
    for (const uint32_t side : {2u, 3u, 4u}) {
        SplitImage image = test::flat_image(kSize, side, 4);
        double all = 0;
        for (uint32_t y = 0; y < kSize.height; ++y)
            for (uint32_t x = 0; x < kSize.width; ++x)
                image.light(x, y) = vec3(float(sqr(float(image.layout.tile_of(image.layout.point_of(x, y))))));
        for (uint32_t tile = 0; tile < side * side; ++tile) all += double(tile) * tile / (side * side);
        for (const uint32_t width : {side, 2 * side, 3 * side}) {
            const std::vector<vec3> filtered = filter(image, {width, 0.9f, 0.02f});
            for (uint32_t y = width; y + width < kSize.height; ++y)
                for (uint32_t x = width; x + width < kSize.width; ++x)
                    ASSERT_NEAR(filtered[image.layout.point_of(x, y)].x, all, 1e-5 * all + 1e-6);
        }
    }
}

TEST(GeometryFilter, IsTheSameForAnyNumberOfThreads) {
    const SplitImage image = test::rough_image({123, 77}, 4, 5);
    const GeometryFilter settings{8, 0.95f, 0.02f};
    const std::vector<vec3> one = test::on_threads(1, [&] { return filter(image, settings); });
    const std::vector<vec3> four = test::on_threads(4, [&] { return filter(image, settings); });
    EXPECT_EQ(std::memcmp(one.data(), four.data(), one.size() * sizeof(vec3)), 0);
}

}  // namespace
}  // namespace photond::geometry_filter_test

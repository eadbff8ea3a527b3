// What the camera sees of a point, against the rays it sends: perspective, orthographic, with a lens.

#include "renderer/eye/camera_connection.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/eye/pixel_filter.h"

namespace photond::camera_connection_test {
namespace {

std::vector<Camera> cameras() {
    Camera pinhole = look_at_camera({1, 2, 3}, {0, 0.5, -1}, {0, 1, 0}, 0.8f);
    Camera lens = pinhole;
    lens.aperture_radius_m = 0.2f;
    lens.focus_distance_m = 2.5f;
    Camera orthographic = pinhole;
    orthographic.orthographic = true;
    orthographic.ymag = 1.5f;
    Camera orthographic_lens = orthographic;
    orthographic_lens.aperture_radius_m = 0.3f;
    orthographic_lens.focus_distance_m = 3;
    return {pinhole, lens, orthographic, orthographic_lens};
}

TEST(CameraConnection, FindsTheRaysThatTheCameraSends) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (const Camera& camera : cameras()) {
        const CameraRays rays(camera, {40, 30});
        const CameraConnector connector(rays);
        for (int i = 0; i < 200; ++i) {
            const vec2 film(40 * random.next(), 30 * random.next()), lens = random.next_2d();
            const Ray ray = rays(film, lens);
            const float distance = 0.5f + 5 * random.next();
            const auto seen = connector.connect(ray.origin + distance * ray.direction, lens);
            ASSERT_TRUE(seen);
            EXPECT_NEAR(seen->film.x, film.x, 2e-3f);
            EXPECT_NEAR(seen->film.y, film.y, 2e-3f);
            EXPECT_LT(glm::length(seen->target - ray.origin), 1e-4f);
            EXPECT_LT(glm::length(seen->to_camera + ray.direction), 1e-5f);
            EXPECT_NEAR(seen->distance, distance, 1e-4f);
            const CameraPdf pdf = connector.pdf(ray.direction);
            EXPECT_EQ(pdf.by_area, camera.orthographic);
            EXPECT_NEAR(seen->pdf / pdf.pdf, 1, 1e-4f);
        }
        const Ray ray = rays({20, 15}, {0.5f, 0.5f});
        EXPECT_FALSE(connector.connect(ray.origin - ray.direction, {0.5f, 0.5f}));  // behind it
    }
}

/// The density is one over the area, or the solid angle, of a pixel: of rays through its corners.
TEST(CameraConnection, DensityIsThatOfAPixel) {
    for (const Camera& camera : cameras()) {
        const Size2 size{4000, 3000};  // so small that a pixel is flat
        const CameraRays rays(camera, size);
        const CameraConnector connector(rays);
        for (const vec2 film : {vec2(2000, 1500), vec2(100, 2900), vec2(3900, 200)}) {
            const vec2 lens(0.8f, 0.3f);
            constexpr float kStep = 10;  // pixels
            const Ray ray = rays(film, lens), x = rays(film + vec2(kStep, 0), lens),
                      y = rays(film + vec2(0, kStep), lens);
            const vec3 area = camera.orthographic
                                  ? glm::cross(x.origin - ray.origin, y.origin - ray.origin)
                                  : glm::cross(x.direction - ray.direction, y.direction - ray.direction);
            const float pixel = std::fabs(glm::dot(area, ray.direction)) / sqr(kStep);
            EXPECT_NEAR(connector.pdf(ray.direction).pdf * pixel, 1, 0.01f);
        }
    }
}

TEST(CameraConnection, PixelsDrawWhereTheirFilterSays) {
    const Size2 size{12, 10};
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (const PixelFilter filter : {PixelFilter::Box, PixelFilter::Gaussian, PixelFilter::BlackmanHarris}) {
        const PixelFilterSampler sampler(filter);
        // A pixel's density, over its neighbourhood in cells of 1/4, against how often it draws there.
        constexpr int kCells = 16;
        constexpr uint32_t kPixel = 5 * 12 + 6;
        std::vector<double> expected(kCells * kCells), drawn(kCells * kCells);
        for (int y = 0; y < kCells; ++y)
            for (int x = 0; x < kCells; ++x)
                for (int k = 0; k < 256; ++k) {
                    const vec2 place(4.5f + (float(x) + (float(k % 16) + 0.5f) / 16) / 4,
                                     3.5f + (float(y) + (float(k / 16) + 0.5f) / 16) / 4);
                    EXPECT_TRUE(sampler.reaches_image(place, size));
                    sampler.visit_pixels(place, size, [&](uint32_t pixel, float density) {
                        if (pixel == kPixel) expected[size_t(y * kCells + x)] += double{density} / 256 / 16;
                    });
                }
        constexpr int kDraws = 200'000;
        for (int i = 0; i < kDraws; ++i) {
            const vec2 offset = sampler(random.next_2d());
            const int x = int(std::floor(4 * (6 + offset.x - 4.5f))), y = int(std::floor(4 * (5 + offset.y - 3.5f)));
            ASSERT_TRUE(x >= 0 && y >= 0 && x < kCells && y < kCells);
            drawn[size_t(y * kCells + x)] += 1;
        }
        double sum = 0;
        for (size_t i = 0; i < expected.size(); ++i) {
            sum += expected[i];
            // Six standard deviations of a count, for 768 counts: 2e-6 of false alarms; the seed is fixed.
            const double deviation = std::sqrt(kDraws * expected[i]) + 1e-3 * kDraws * expected[i];
            EXPECT_NEAR(drawn[i], kDraws * expected[i], 6 * deviation + 1e-9) << i;
        }
        EXPECT_NEAR(sum, 1, 1e-3);
    }
    const PixelFilterSampler box(PixelFilter::Box);
    EXPECT_FALSE(box.reaches_image({-0.1f, 3}, size));
    EXPECT_FALSE(box.reaches_image({3, 10}, size));
}

}  // namespace
}  // namespace photond::camera_connection_test

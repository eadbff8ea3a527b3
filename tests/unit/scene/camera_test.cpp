// Camera rays: where pixels look, thin lens, orthographic views, and what look_at refuses.

#include "renderer/scene/camera.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/core/rng.h"

namespace photond::camera_test {
namespace {

constexpr Size2 kFilm{200, 100};

TEST(CameraRay, KeepsYfovAndWidensWithTheImage) {
    const Camera camera = look_at_camera({1, 2, 3}, {1, 2, -7}, {0, 1, 0}, 1.0f);
    EXPECT_NEAR(glm::length(camera_ray(camera, kFilm, {100, 50}, {}).direction - vec3(0, 0, -1)), 0, 1e-6);
    const vec3 top = camera_ray(camera, kFilm, {100, 0}, {}).direction;
    EXPECT_NEAR(std::atan2(top.y, -top.z), 0.5, 1e-6) << "row 0 is the top; yfov is the full angle";
    const vec3 left = camera_ray(camera, kFilm, {0, 50}, {}).direction;
    EXPECT_NEAR(-left.x / -left.z, 2 * std::tan(0.5), 1e-6) << "square pixels";
    EXPECT_EQ(camera_ray(camera, kFilm, {13, 77}, {0.3f, 0.9f}).origin, vec3(1, 2, 3)) << "a pinhole ignores the lens";
}

TEST(CameraRay, FrameIsOrthonormalForAnyUp) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    const auto vector = [&] { return dvec3(random.next(), random.next(), random.next()) - 0.5; };
    for (int i = 0; i < 1000; ++i) {
        const dvec3 eye = 10.0 * vector(), target = 10.0 * vector(),
                    up = vector() * std::pow(10.0, 20 * random.next() - 10);
        const Camera c = look_at_camera(eye, target, up, 0.7f);
        EXPECT_NEAR(glm::dot(c.right, c.up), 0, 1e-6);
        EXPECT_NEAR(glm::dot(c.right, c.forward), 0, 1e-6);
        EXPECT_NEAR(glm::length(glm::cross(c.right, c.up) + c.forward), 0, 1e-5) << "looks along -z of its frame";
        EXPECT_GT(glm::dot(dvec3(c.up), up), 0);
        EXPECT_NEAR(glm::length(dvec3(c.forward) - glm::normalize(target - eye)), 0, 1e-6);
    }
}

TEST(CameraRay, ThinLensFocusesOnAPlanePerpendicularToForward) {
    Camera camera = look_at_camera({0, 1, 5}, {2, 0, -1}, {0, 1, 0}, 0.8f);
    camera.aperture_radius_m = 0.2f;
    camera.focus_distance_m = 3.5f;
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (const vec2 film : {vec2(100, 50), vec2(3, 7), vec2(199, 99)}) {
        Camera pinhole = camera;
        pinhole.aperture_radius_m = 0;
        const Ray centre = camera_ray(pinhole, kFilm, film, {});
        const vec3 sharp = centre.origin + centre.direction * (3.5f / glm::dot(centre.direction, camera.forward));
        float farthest = 0;
        for (int i = 0; i < 500; ++i) {
            const Ray ray = camera_ray(camera, kFilm, film, random.next_2d());
            EXPECT_NEAR(glm::length(ray.direction), 1, 1e-6);
            const vec3 on_lens = ray.origin - camera.position;
            EXPECT_NEAR(glm::dot(on_lens, camera.forward), 0, 1e-6);
            farthest = std::max(farthest, glm::length(on_lens));
            EXPECT_LE(glm::length(on_lens), 0.2f * 1.00001f);
            const float t = 3.5f / glm::dot(ray.direction, camera.forward);
            EXPECT_NEAR(glm::length(ray.origin + t * ray.direction - sharp), 0, 1e-5);
        }
        EXPECT_GT(farthest, 0.18f) << "the whole lens is used";
    }
}

TEST(CameraRay, LensIsSampledEvenly) {
    // Mean squared distance from the centre of a uniform disc is half its radius squared.
    Camera camera;
    camera.aperture_radius_m = 1;
    double sum = 0;
    constexpr int kSide = 200;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const vec3 o =
                camera_ray(camera, kFilm, {100, 50}, (vec2(float(x), float(y)) + 0.5f) / float{kSide}).origin;
            sum += double{glm::dot(o, o)};
        }
    EXPECT_NEAR(sum / (kSide * kSide), 0.5, 1e-3);
}

TEST(CameraRay, Orthographic) {
    Camera camera = look_at_camera({0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 1.0f);
    camera.orthographic = true;
    camera.ymag = 3;
    const Ray corner = camera_ray(camera, kFilm, {0, 0}, {});
    EXPECT_NEAR(glm::length(corner.origin - vec3(-6, 3, 10)), 0, 1e-5);
    EXPECT_NEAR(glm::length(corner.direction - vec3(0, 0, -1)), 0, 1e-6);
    camera.aperture_radius_m = 0.5f;
    camera.focus_distance_m = 4;
    const Ray lens = camera_ray(camera, kFilm, {0, 0}, {0.9f, 0.2f});
    const float t = 4 / glm::dot(lens.direction, camera.forward);
    EXPECT_NEAR(glm::length(lens.origin + t * lens.direction - vec3(-6, 3, 6)), 0, 1e-5);
}

TEST(CameraRay, TinyAndHugeScenes) {
    for (const double scale : {1e-5, 1.0, 1e6}) {
        const Camera camera = look_at_camera(dvec3(1, 2, 3) * scale, dvec3(-1, 0.5, 0) * scale, {0, 1, 0}, 0.6f);
        const Camera one = look_at_camera({1, 2, 3}, {-1, 0.5, 0}, {0, 1, 0}, 0.6f);
        const vec3 a = camera_ray(camera, kFilm, {17, 3}, {}).direction,
                   b = camera_ray(one, kFilm, {17, 3}, {}).direction;
        EXPECT_NEAR(glm::length(a - b), 0, 1e-6);
        EXPECT_NEAR(camera.focus_distance_m / (scale * one.focus_distance_m), 1, 1e-6);
    }
}

TEST(LookAt, RefusesWhatDefinesNoView) {
    const auto refused_at = [](dvec3 eye, dvec3 target, dvec3 up, float yfov) -> std::string {
        try {
            look_at_camera(eye, target, up, yfov);
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::OutOfRange);
            return error.faults.at(0).pointer;
        }
        return "accepted";
    };
    const double nan = std::nan("");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, 0, 0}, {0, 1, 0}, 0.7f), "/camera/look_at/target");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, 5, 0}, {0, 1, 0}, 0.7f), "/camera/look_at/up");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, -5, 0}, {0, 1, 0}, 0.7f), "/camera/look_at/up");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, 0, 1}, {0, 0, 0}, 0.7f), "/camera/look_at/up");
    EXPECT_EQ(refused_at({nan, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.7f), "/camera/look_at/eye");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, HUGE_VAL, 1}, {0, 1, 0}, 0.7f), "/camera/look_at/target");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.0f), "/camera/look_at/yfov");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 3.2f), "/camera/look_at/yfov");
    EXPECT_EQ(refused_at({0, 0, 0}, {0, 0, 1}, {0, 1e-200, 0}, 0.7f), "accepted");
}

}  // namespace
}  // namespace photond::camera_test

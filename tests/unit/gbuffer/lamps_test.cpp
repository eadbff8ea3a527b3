// What lamps look like from afar.

#include "renderer/gbuffer/lamps.h"

#include <gtest/gtest.h>

#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/emitter.h"
#include "renderer/transport/light_sampling.h"
#include "tests/support/scene_parts.h"

namespace photond::lamps_test {
namespace {

/// lamp_radius_m() of lamps.glsl.
float radius_m(const gpu::LampShape& shape, const vec3& w) {
    const vec3 yzx(w.y, w.z, w.x), zxy(w.z, w.x, w.y);
    const float along = glm::dot(shape.variance_m2, w * w) + 2 * glm::dot(shape.covariance_m2, yzx * zxy);
    const float all = shape.variance_m2.x + shape.variance_m2.y + shape.variance_m2.z;
    return std::sqrt(2 * (all - along));
}

// A disc of radius r about (3, 2, 1), across a skew direction.
TEST(Lamps, OfDiscsIsTheirRadiusAlongTheirAxis) {
    const vec3 axis = glm::normalize(vec3(1, 2, -2)), side = glm::normalize(glm::cross(axis, vec3(0, 1, 0)));
    const vec3 up = glm::cross(axis, side), centre(3, 2, 1);
    constexpr int kSlices = 200;
    MeshBuilder builder;
    const auto rim = [&](int i) {
        const float angle = 2 * kPi * float(i) / kSlices;
        return centre + 0.25f * (std::cos(angle) * side + std::sin(angle) * up);
    };
    for (int i = 0; i < kSlices; ++i) builder.triangle(centre, rim(i), rim(i + 1));
    Scene scene;
    test::add(scene, builder.build(0), test::lambert(0.5f));
    test::add(scene, builder.build(0), test::emitting(Rgb(1, 2, 3)));
    finish_scene(scene);
    const std::vector<gpu::LampShape> shapes = find_lamps(scene).shapes;
    ASSERT_EQ(shapes.size(), 1u);
    EXPECT_LT(glm::length(shapes[0].centre - centre), 1e-5f);
    EXPECT_NEAR(radius_m(shapes[0], axis), 0.25f, 1e-3f);
    EXPECT_NEAR(radius_m(shapes[0], side), 0.25f / std::sqrt(2.0f), 1e-3f) << "seen from its side it has one axis";
}

// The places of a sphere's surface are wider spread than those of the disc it looks like: by sqrt(4/3).
TEST(Lamps, OfSpheresAreTheSameFromAllSides) {
    Scene scene;
    test::add(scene, MeshBuilder().sphere({0, 5, 0}, 0.3f, 96).build(0), test::emitting(Rgb(1)));
    finish_scene(scene);
    const gpu::LampShape shape = find_lamps(scene).shapes.at(0);
    for (const vec3& w : {vec3(1, 0, 0), vec3(0, 1, 0), glm::normalize(vec3(1, 1, 1))})
        EXPECT_NEAR(radius_m(shape, w), 0.3f * std::sqrt(4.0f / 3), 2e-3f);
}

// Two bulbs of one mesh cast two shadows; the two triangles of a panel, which hang together, cast one.
TEST(Lamps, AreWhatHangsTogether) {
    Scene scene;
    test::add(scene,
              MeshBuilder()
                  .sphere({0, 2, 0}, 0.1f, 8)
                  .sphere({1, 2, 0}, 0.1f, 8)
                  .quad({2, 2, 0}, {3, 2, 0}, {3, 2, 1}, {2, 2, 1})
                  .build(0),
              test::emitting(Rgb(1)));
    PunctualLight point, sun;
    point.position = {1, 2, 3};
    sun.kind = PunctualLight::Kind::Directional;
    scene.punctual_lights = {sun, point};
    finish_scene(scene);
    const Lamps lamps = find_lamps(scene);
    ASSERT_EQ(lamps.shapes.size(), 5u);
    EXPECT_LT(glm::length(lamps.shapes[0].centre - vec3(0, 2, 0)), 1e-5f);
    EXPECT_LT(glm::length(lamps.shapes[1].centre - vec3(1, 2, 0)), 1e-5f);
    EXPECT_LT(glm::length(lamps.shapes[2].centre - vec3(2.5f, 2, 0.5f)), 1e-5f);
    EXPECT_EQ(lamps.shapes[4].centre, vec3(1, 2, 3));
    EXPECT_EQ(radius_m(lamps.shapes[4], vec3(0, 1, 0)), 0);
    // Each emitter is part of the lamp that it is nearest to.
    const LightSampler sampler(scene);
    ASSERT_EQ(lamps.words.size(), LAMP_OF_EMITTERS + sampler.emitters().size());
    EXPECT_EQ(lamps.words[LAMP_FIRST_PUNCTUAL], 3u);
    for (size_t i = 0; i < sampler.emitters().size(); ++i) {
        const Emitter& emitter = sampler.emitters()[i];
        uint32_t nearest = 0;
        for (uint32_t lamp = 1; lamp < lamps.shapes.size(); ++lamp)
            if (glm::length(lamps.shapes[lamp].centre - emitter.corner) <
                glm::length(lamps.shapes[nearest].centre - emitter.corner))
                nearest = lamp;
        EXPECT_EQ(lamps.words[LAMP_OF_EMITTERS + i], nearest);
    }
}

}  // namespace
}  // namespace photond::lamps_test

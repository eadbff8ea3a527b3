// Photon splatting by connections against path tracing with the same bounces: the mean of the indirect layer, over the
// image.

#include <gtest/gtest.h>

#include <cstdio>

#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/path_render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"

namespace photond::photon_splatting_test {
namespace {

using Settings = test::RenderSettingsOf<PhotonSplatting>;

constexpr double kFalseAlarm = 1e-6;  // of each test
constexpr size_t kSeeds = 32;

/// A room of 2 m whose rear wall has a normal map and which holds a smooth sphere, lit by its ceiling's middle.
Scene room_with_leaning_normals() {
    Scene scene;
    test::add(scene, MeshBuilder().quad({-1, -1, 1}, {1, -1, 1}, {1, -1, -1}, {-1, -1, -1}).build(0),
              test::lambert(0.7f));
    test::add(scene, MeshBuilder().quad({-1, 1, 1}, {-1, 1, -1}, {1, 1, -1}, {1, 1, 1}).build(0), test::lambert(0.7f));
    test::add(scene, MeshBuilder().quad({-1, -1, 1}, {-1, -1, -1}, {-1, 1, -1}, {-1, 1, 1}).build(0),
              test::lambert(0.3f));
    test::add(scene, MeshBuilder().quad({1, -1, 1}, {1, 1, 1}, {1, 1, -1}, {1, -1, -1}).build(0), test::lambert(0.5f));
    Texture bumps;
    bumps.size = {2, 2};
    bumps.texels = {u8vec4(60, 150, 220, 255), u8vec4(180, 100, 220, 255), u8vec4(128, 200, 200, 255),
                    u8vec4(128, 128, 255, 255)};
    scene.textures = {bumps};
    Material bumpy = test::lambert(0.7f);
    bumpy.normal_texture.texture = 0;
    test::add(scene, MeshBuilder().quad({-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}).build(0, true), bumpy);
    test::add(scene, MeshBuilder().sphere({0.3f, -0.5f, -0.2f}, 0.4f, 12).build(0), test::lambert(0.8f));
    test::add(scene,
              MeshBuilder()
                  .quad({-0.3f, 0.99f, 0.3f}, {-0.3f, 0.99f, -0.3f}, {0.3f, 0.99f, -0.3f}, {0.3f, 0.99f, 0.3f})
                  .build(0),
              test::emitting(Rgb(10)));
    Camera camera;
    camera.position = vec3(0, 0, 0.98f);
    scene.cameras = {camera};
    finish_scene(scene);
    return scene;
}

struct Check {
    const char* name;
    Scene scene;
    uint32_t bounces;
    void (*set)(PhotonSplattingParams& params) = [](PhotonSplattingParams&) {};
};

/// Relative difference of the layer's mean from path tracing's: seeds are independent renders of either method.
test::Interval difference(const Check& check, size_t checks) {
    test::RunningMean splatted, traced;
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
        Settings settings;
        settings.size = {32, 32};
        settings.passes = 4;
        settings.seed = seed;
        settings.params.photons = 1500;
        settings.params.bounces = check.bounces;
        check.set(settings.params);
        test::RenderSettings reference;
        reference.size = settings.size;
        reference.passes = 48;
        reference.params.indirect_bounces = check.bounces;
        reference.seed = 1000 + seed;
        splatted.add(test::mean_of(test::render(check.scene, settings).resolve(Layer::Indirect)));
        traced.add(test::mean_of(test::render(check.scene, reference).resolve(Layer::Indirect)));
    }
    // Welch's interval, with the fewer degrees of freedom.
    const double t = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, checks), kSeeds - 1);
    return {splatted.mean() / traced.mean() - 1,
            t * std::hypot(splatted.standard_error(), traced.standard_error()) / traced.mean()};
}

void expect_agreement(const std::vector<Check>& checks, double must_detect) {
    for (const Check& check : checks) {
        const test::Interval interval = difference(check, checks.size());
        std::printf("%-40s %d bounces: %+.4f +- %.4f\n", check.name, int(check.bounces), interval.mean,
                    interval.half_width);
        EXPECT_LE(std::abs(interval.mean), interval.half_width) << check.name << ", " << check.bounces << " bounces";
        EXPECT_LE(interval.half_width, must_detect) << check.name << ": too noisy to notice a defect";
    }
}

// All lobes that are no delta connect, and wait for splats: no kernel's bias.
void connect_all(PhotonSplattingParams& p) { p.glossy_threshold = p.connect_threshold = 0; }

TEST(PhotonSplattingReference, SeveralBouncesAgreeWithPathTracing) {
    std::vector<Check> checks;
    for (const uint32_t bounces : {2u, 3u})
        checks.push_back({"cornell-box", make_builtin_scene("cornell-box"), bounces});
    checks.push_back({"cornell-box-glossy", make_builtin_scene("cornell-box-glossy"), 2, connect_all});
    checks.push_back({"leaning normals", room_with_leaning_normals(), 2});
    expect_agreement(checks, 0.15);
}

TEST(LongPhotonSplattingReference, EveryWayAgreesWithPathTracing) {
    std::vector<Check> checks;
    checks.push_back({"cornell-box", make_builtin_scene("cornell-box"), 1});
    checks.push_back({"wide splats", make_builtin_scene("cornell-box"), 1,
                      [](PhotonSplattingParams& p) { p.splat_size_relative = 0.4f; }});
    checks.push_back({"reflective shadow map", make_builtin_scene("cornell-box-spot"), 1,
                      [](PhotonSplattingParams& p) { p.injection = PhotonInjection::ReflectiveShadowMap; }});
    checks.push_back({"stratified by power", make_builtin_scene("cornell-box"), 2,
                      [](PhotonSplattingParams& p) { p.stratify = true, p.grid_cells = 32; }});
    checks.push_back({"four rays, tent", make_builtin_scene("cornell-box"), 1, [](PhotonSplattingParams& p) {
                          p.rays_per_photon = 4, p.filter = SplatFilter::Tent, p.photons = 600;
                      }});
    for (const uint32_t bounces : {1u, 3u}) {
        checks.push_back({"cornell-box-glossy", make_builtin_scene("cornell-box-glossy"), bounces, connect_all});
        checks.push_back({"leaning normals", room_with_leaning_normals(), bounces});
    }
    expect_agreement(checks, 0.2);
}

}  // namespace
}  // namespace photond::photon_splatting_test

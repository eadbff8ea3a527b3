// Shadows of lights' middles, blurred in the image: against shadow rays to the whole of the light.

#include <gtest/gtest.h>

#include "renderer/error/flip.h"
#include "renderer/methods/image_space_photon_mapping/image_space_photon_mapping_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/gpu_render.h"
#include "tests/support/open_scene.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_soft_shadows_test {
namespace {

using Ispm = ImageSpacePhotonMappingGpu;

constexpr Size2 kSize{64, 48};

/// The Cornell box with a lamp that is as wide as a disc of that radius, and of the same power.
Scene box_with_lamp_of(float radius_m) {
    Scene scene = make_builtin_scene("cornell-box");
    double area_m2 = 0;
    for (const TriangleLight& light : scene.triangle_lights) area_m2 += double{light.area_m2};
    const float scale = radius_m * float(std::sqrt(double{kPi} / area_m2));
    Mesh& lamp = scene.meshes[scene.instances[scene.triangle_lights.front().instance].mesh];
    vec3 centre(0);
    for (const vec3& p : lamp.positions) centre += p / float(lamp.positions.size());
    for (vec3& p : lamp.positions) p = centre + scale * (p - centre);
    scene.materials[lamp.material].emission /= sqr(scale);
    finish_scene(scene);
    return scene;
}

test::RenderSettingsOf<Ispm> direct_light(SoftShadow soft_shadow, uint32_t passes) {
    test::RenderSettingsOf<Ispm> settings;
    settings.size = kSize;
    settings.passes = passes;
    settings.params.bounces = 0;
    settings.params.soft_shadow = soft_shadow;
    return settings;
}

std::vector<float> direct_of(const test::SceneOnDevice& where, SoftShadow soft_shadow, uint32_t passes) {
    return test::render(where, direct_light(soft_shadow, passes)).resolve(Layer::Direct);
}

TEST(GpuSoftShadows, GatheredOnesLookLikeThoseOfRays) {
    for (const float radius_m : {0.05f, 0.2f}) {
        const Scene scene = box_with_lamp_of(radius_m);
        const test::SceneOnDevice where(scene);
        const Flip flip(kSize, direct_of(where, SoftShadow::Rays, 64), FlipRange::Hdr);
        const double hard = flip.measure(direct_of(where, SoftShadow::None, 32)).mean;
        const double gathered = flip.measure(direct_of(where, SoftShadow::Gather, 32)).mean;
        std::printf("lamp of %.2f m: FLIP %.4f with hard shadows, %.4f with gathered ones\n", double{radius_m}, hard,
                    gathered);
        EXPECT_LT(gathered, 0.05);
        EXPECT_LE(gathered, hard) << "the same where a penumbra is narrower than a pixel";
    }
}

// A point has the same shadow by whatever means, but for light that rounding sends elsewhere.
TEST(GpuSoftShadows, OfPointsAreHard) {
    const Scene scene = make_builtin_scene("cornell-box-spot");
    const test::SceneOnDevice where(scene);
    const std::vector<float> rays = direct_of(where, SoftShadow::Rays, 2);
    EXPECT_GT(test::mean_of(rays), 0);
    for (const SoftShadow soft : {SoftShadow::Gather, SoftShadow::FixedRadius, SoftShadow::None})
        EXPECT_LT(test::mean_relative_difference(rays, direct_of(where, soft, 2)), 1e-4);
}

// Where nothing hides anything there is nothing to gather: the light is path tracing's.
TEST(GpuSoftShadows, LightThatNothingHidesIsWhole) {
    Scene scene;
    test::add(scene, MeshBuilder().quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}).build(0), test::lambert(0.5f));
    test::add(scene, MeshBuilder().quad({-1, 3, -1}, {1, 3, -1}, {1, 3, 1}, {-1, 3, 1}).build(0), test::lambert(0, 5));
    finish_scene(scene);
    const test::SceneOnDevice where(scene);
    const double wanted = test::mean_of(direct_of(where, SoftShadow::Rays, 16));
    EXPECT_GT(wanted, 0);
    for (const SoftShadow soft : {SoftShadow::Gather, SoftShadow::FixedRadius, SoftShadow::None})
        EXPECT_NEAR(test::mean_of(direct_of(where, soft, 16)), wanted, 1e-5 * wanted) << "the same light samples";
}

// Each lamp has its own shadow: neighbours that are lit by another one are not asked for it.
TEST(GpuSoftShadows, OfManyLampsAreNearerToRaysThanHardOnes) {
    Scene scene;
    test::add(scene, MeshBuilder().quad({-3, 0, 3}, {3, 0, 3}, {3, 0, -3}, {-3, 0, -3}).build(0), test::lambert(0.5f));
    test::add(scene, MeshBuilder().box({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}).build(0), test::lambert(0.5f));
    MeshBuilder lamps;
    for (const float x : {-1.5f, 2.0f}) lamps.quad({x, 2.5f, -1}, {x + 1, 2.5f, -1}, {x + 1, 2.5f, 0}, {x, 2.5f, 0});
    test::add(scene, lamps.build(0), test::lambert(0, 20));
    PunctualLight point;
    point.position = {0, 2, 2};
    scene.punctual_lights.push_back(point);
    scene.cameras.push_back(look_at_camera({0.5, 3, 2.5}, {0.5, 0, 0}, {0, 1, 0}, 0.6f));  // near: penumbrae are wide
    finish_scene(scene);
    const test::SceneOnDevice where(scene);
    const std::vector<float> rays = direct_of(where, SoftShadow::Rays, 96);
    const std::vector<float> gathered = direct_of(where, SoftShadow::Gather, 64);
    const double apart = test::mean_relative_difference(rays, gathered);
    const double hard_apart = test::mean_relative_difference(rays, direct_of(where, SoftShadow::None, 64));
    std::printf("of the light %.4f lies elsewhere, with hard shadows %.4f\n", apart, hard_apart);
    EXPECT_LT(apart, 0.8 * hard_apart);
}

TEST(GpuSoftShadows, OnePassOrThreeMakeTheSameImage) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ispm> settings = direct_light(SoftShadow::Gather, 2);
    settings.params.bounces = 2;
    settings.params.photons = 4000;
    settings.params.subsampling = 4;
    for (const Layer layer : {Layer::ShadowDistance, Layer::BlurRadius, Layer::UpsamplingWeight})
        settings.layers.add(layer);
    const Film together = test::render(where, settings);
    settings.params.one_pass = false;
    EXPECT_EQ(together.pixel_hash(), test::render(where, settings).pixel_hash());
    for (const Layer layer : {Layer::ShadowDistance, Layer::BlurRadius, Layer::UpsamplingWeight})
        EXPECT_GT(test::mean_of_layer(together, layer), 0) << layer_info(layer).name;
}

TEST(GpuSoftShadows, TakeTheMemoryTheySay) {
    const Scene scene = make_builtin_scene("cornell-box");
    test::RenderSettingsOf<Ispm> settings = direct_light(SoftShadow::Gather, 1);
    settings.size = {256, 192};
    test::expect_device_bytes_as_estimated<Ispm>(test::SceneOnDevice(scene), settings);
}

}  // namespace
}  // namespace photond::gpu_soft_shadows_test

// Image-based lighting on a device: the CPU's image, and the same from run to run.

#include <gtest/gtest.h>

#include "renderer/methods/image_based_lighting/image_based_lighting_gpu.h"
#include "tests/support/environment_scenes.h"
#include "tests/support/gpu_render.h"

namespace photond::gpu_image_based_lighting_test {
namespace {

template <class M>
test::RenderSettingsOf<M> small(uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {48, 36};
    settings.passes = passes;
    settings.params.prefilter_resolution = 64;
    settings.params.prefilter_levels = 5;
    return settings;
}

Scene balls() {
    Environment sky = test::sky_with_sun({64, 32}, 0.1f);
    sky.rotation = 2, sky.scale = 0.5f;
    Scene scene = test::balls_under(std::move(sky));
    test::add_lamp(scene);
    return test::turned(std::move(scene));
}

/// Rounding sends few paths elsewhere, through glass most of them.
TEST(GpuImageBasedLighting, IsTheImageOfTheCpu) {
    const Scene scene = balls();
    const test::SceneOnDevice where(scene);
    Stats on_cpu, on_gpu;
    const Film cpu = test::render(scene, small<ImageBasedLighting>(2), &on_cpu),
               gpu = test::render(where, small<ImageBasedLightingGpu>(2), &on_gpu);
    for (const Layer layer : {Layer::Emitted, Layer::Direct}) {
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 1e-3), 0.01);
        EXPECT_LT(test::mean_relative_difference(cpu.resolve(layer), gpu.resolve(layer)), 5e-3);
    }
    EXPECT_GT(test::mean_of(gpu.resolve(Layer::Direct)), 0);
    for (const float value : gpu.resolve(Layer::Indirect)) ASSERT_EQ(value, 0);
    EXPECT_NEAR(double(on_gpu.counts.shadow_rays), double(on_cpu.counts.shadow_rays),
                0.01 * double(on_cpu.counts.shadow_rays));
    for (const Skipped& part : on_cpu.skipped)
        EXPECT_TRUE(std::any_of(on_gpu.skipped.begin(), on_gpu.skipped.end(), [&](const Skipped& other) {
            return other.what == part.what && other.why == part.why;
        })) << part.what;
}

TEST(GpuImageBasedLighting, IsTheSameFromRunToRunAndInParts) {
    const Scene scene = balls();
    const test::SceneOnDevice where(scene);
    const auto settings = small<ImageBasedLightingGpu>(3);
    Film whole = test::render(where, settings);
    EXPECT_EQ(test::render(where, settings).resolve(Layer::Direct), whole.resolve(Layer::Direct));
    Film parts = test::render(where, small<ImageBasedLightingGpu>(1));
    auto rest = small<ImageBasedLightingGpu>(2);
    rest.first_pass = 1;
    parts.merge(test::render(where, rest));
    EXPECT_EQ(parts.resolve(Layer::Direct), whole.resolve(Layer::Direct));
}

TEST(GpuImageBasedLighting, LambertScenesAndScenesWithoutAnEnvironmentAreTheCpusToo) {
    Scene lambert = test::floor_under(test::lambert(0.5f), test::sky({64, 32}));
    Scene dark = lambert;
    dark.environment.reset();
    test::add_lamp(dark);
    for (const Scene* scene : {&lambert, &dark}) {
        const test::SceneOnDevice where(*scene);
        const Film cpu = test::render(*scene, small<ImageBasedLighting>(1)),
                   gpu = test::render(where, small<ImageBasedLightingGpu>(1));
        EXPECT_LT(test::share_apart(cpu.resolve(Layer::Direct), gpu.resolve(Layer::Direct), 1e-3), 0.01);
        EXPECT_GT(test::mean_of(gpu.resolve(Layer::Direct)), 0);
    }
}

TEST(GpuImageBasedLighting, TakesTheMemoryThatItSays) {
    const Scene scene = balls();
    const test::SceneOnDevice where(scene);
    test::expect_device_bytes_as_estimated(where, small<ImageBasedLightingGpu>(1));
    MemoryBudget budget;
    Stats stats;
    const auto settings = small<ImageBasedLightingGpu>(1);
    ImageBasedLightingGpu method(settings.params);
    method.begin({scene, &where.intersector, test::view_of(scene, settings), 1, budget, &where.device_scene}, stats);
    const uint64_t estimate =
        ImageBasedLightingGpu::estimate_bytes(settings.params, test::workload_of(scene, settings));
    EXPECT_NEAR(double(budget.accounted_bytes()) / double(estimate), 1, 0.05);
}

}  // namespace
}  // namespace photond::gpu_image_based_lighting_test

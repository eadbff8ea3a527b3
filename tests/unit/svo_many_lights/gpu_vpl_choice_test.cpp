// Lights chosen for each point on a GPU against the CPU's choice: the same means.

#include <gtest/gtest.h>

#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_vpl_choice_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_for(VplChoice choice, uint32_t passes, uint64_t seed) {
    test::RenderSettingsOf<M> settings;
    settings.size = {24, 16};
    settings.passes = passes;
    settings.seed = seed;
    settings.params.vpls = 200;
    settings.params.map_resolution = 32;
    settings.params.visibility = VplVisibility::Rays;
    settings.params.bounces = 2;
    settings.params.caustic_photons = 0;
    settings.params.vpl_choice = choice;
    settings.params.cut_size = 20;
    settings.params.resampled_vpls = 5;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

class GpuVplChoice : public testing::TestWithParam<VplChoice> {};

/// `placement`: the GPU's; the CPU's is by flux.
void expect_the_means_of_the_cpu(const char* scene_name, VplChoice choice, VplVisibility visibility, uint32_t passes,
                                 VplPlacement placement = VplPlacement::Flux) {
    const Scene scene = test::turned(make_builtin_scene(scene_name));
    auto cpu_settings = settings_for<SvoManyLights>(choice, passes, 1);
    auto gpu_settings = settings_for<SvoManyLightsGpu>(choice, passes, 2);
    for (SvoManyLightsParams* params : {&cpu_settings.params, &gpu_settings.params})
        params->visibility = visibility, params->voxel_resolution = 64;
    gpu_settings.params.placement = placement;
    const auto cpu = test::render_blocks(scene, cpu_settings, 8);
    const auto gpu = test::render_blocks(test::SceneOnDevice(scene), gpu_settings, 8);
    const test::BlockTest blocks = test::compare_blocks(cpu.blocks, gpu.blocks);
    EXPECT_EQ(blocks.alarms, 0u) << scene_name << " " << static_cast<int>(visibility) << "\n" << blocks.table();
}

TEST_P(GpuVplChoice, HasTheMeansOfTheCpu) {
    expect_the_means_of_the_cpu("cornell-box", GetParam(), VplVisibility::Rays, 24);
}

// Choices take lights of little worth for less than their size: that must not show in the mean.
TEST_P(GpuVplChoice, HasTheMeansOfLightsByFluxWhereverTheyArePlaced) {
    const bool lightcut = GetParam() == VplChoice::Lightcut;
    expect_the_means_of_the_cpu("cornell-box", GetParam(), VplVisibility::Rays, 24,
                                lightcut ? VplPlacement::Acceptance : VplPlacement::Metropolis);
}

TEST_P(GpuVplChoice, LongHasTheMeansOfTheCpuWhateverReflectsAndWhoeverAnswers) {
    expect_the_means_of_the_cpu("interior", GetParam(), VplVisibility::Rays, 100);
    for (const VplVisibility visibility : {VplVisibility::Svo, VplVisibility::ShadowMaps, VplVisibility::None})
        expect_the_means_of_the_cpu("cornell-box-glossy", GetParam(), visibility, 40);
}

TEST_P(GpuVplChoice, AsksNoMoreThanItSays) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    auto settings = settings_for<SvoManyLightsGpu>(GetParam(), 2, 1);
    settings.params.visibility = VplVisibility::Svo;
    settings.params.voxel_resolution = 64;
    settings.params.repay = false;
    Stats stats;
    const Film film = test::render(where, settings, &stats);
    EXPECT_GT(test::mean_of(film.resolve(Layer::Indirect)), 0);
    EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
    const uint64_t most = GetParam() == VplChoice::Lightcut ? settings.params.cut_size : settings.params.resampled_vpls;
    const uint64_t pixels = settings.size.pixels() * settings.passes;
    EXPECT_LE(stats.counts.shadow_rays, (most + 1) * pixels);  // one to the scene's own light
    EXPECT_GT(stats.counts.shadow_rays, 2 * pixels);
    EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash()) << "the same bits each time";
}

TEST_P(GpuVplChoice, TakesTheMemoryItSays) {
    auto settings = settings_for<SvoManyLightsGpu>(GetParam(), 1, 1);
    settings.params.vpls = 10'000;
    settings.params.bounces = 1;
    settings.params.visibility = VplVisibility::Svo;
    const Scene scene = make_builtin_scene("cornell-box");
    test::expect_device_bytes_as_estimated(test::SceneOnDevice(scene), settings);
}

INSTANTIATE_TEST_SUITE_P(Choices, GpuVplChoice, testing::Values(VplChoice::Lightcut, VplChoice::Resampled),
                         [](const auto& info) { return info.param == VplChoice::Lightcut ? "Lightcut" : "Resampled"; });

}  // namespace
}  // namespace photond::gpu_vpl_choice_test

// Many lights on a GPU against the CPU's: the same points, lights and random numbers, but for rounding; and what a
// method promises beside.

#include <gtest/gtest.h>

#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_svo_many_lights_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_for(uint32_t passes, VplVisibility visibility) {
    test::RenderSettingsOf<M> settings;
    settings.size = {40, 30};  // tiles cut at both edges
    settings.passes = passes;
    settings.params.vpls = 96;
    settings.params.bounces = 1;
    settings.params.caustic_photons = 0;  // but where they are asked for
    settings.params.map_resolution = 32;
    settings.params.voxel_resolution = 64;
    settings.params.shadow_resolution = 16;
    settings.params.visibility = visibility;
    settings.params.vpl_choice = VplChoice::Interleaved;
    settings.params.interleave = 1;
    settings.params.roulette = 0;
    // The same for all: pipelines are compiled for a set of layers.
    for (const Layer layer : {Layer::Albedo, Layer::Normal, Layer::Depth, Layer::Clamped, Layer::Voxels, Layer::Vpls,
                              Layer::SplitNormal, Layer::SplitIndirect})
        settings.layers.add(layer);
    return settings;
}

struct Case {
    const char* scene;
    VplVisibility visibility;
    void (*change)(SvoManyLightsParams& params) = [](SvoManyLightsParams&) {};
};

class GpuSvoManyLights : public testing::TestWithParam<Case> {};

// The same lights, all asked by each point: rounding alone tells the images apart. A light that it sends elsewhere, or
// to whom it answers otherwise for V, is one of a hundred: most values agree to a hundredth of the mean, and means to
// 0.3 %. What is repaid is found by a hundred of the short rays, of which one weighs as much.
TEST_P(GpuSvoManyLights, FollowsTheCpu) {
    const Case& of = GetParam();
    const Scene scene = test::turned(make_builtin_scene(of.scene));
    auto cpu_settings = settings_for<SvoManyLights>(2, of.visibility);
    auto gpu_settings = settings_for<SvoManyLightsGpu>(2, of.visibility);
    of.change(cpu_settings.params), of.change(gpu_settings.params);
    Stats cpu_stats, gpu_stats;
    const Film cpu = test::render(scene, cpu_settings, &cpu_stats);
    const Film gpu = test::render(test::SceneOnDevice(scene), gpu_settings, &gpu_stats);
    for (const Layer layer :
         {Layer::Emitted, Layer::Direct, Layer::Albedo, Layer::Normal, Layer::Depth, Layer::Voxels, Layer::SplitNormal})
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 1e-3), 0.02) << layer_info(layer).name;
    for (const auto& [layer, tolerance] :
         {std::pair(Layer::Indirect, 3e-3), {Layer::SplitIndirect, 3e-3}, {Layer::Clamped, 5e-2}}) {
        const std::vector<float> a = cpu.resolve(layer), b = gpu.resolve(layer);
        EXPECT_LT(test::share_apart(a, b, 1e-2), 0.05) << layer_info(layer).name;
        EXPECT_NEAR(test::mean_of(b), test::mean_of(a), tolerance * test::mean_of(a)) << layer_info(layer).name;
    }
    EXPECT_LT(test::share_apart(cpu.resolve(Layer::Vpls), gpu.resolve(Layer::Vpls), 0.5), 0.02);
    EXPECT_GT(test::mean_of(cpu.resolve(Layer::Indirect)), 0);
    const Counts &a = cpu_stats.counts, &b = gpu_stats.counts;
    EXPECT_EQ(a.camera_rays, b.camera_rays);
    EXPECT_NEAR(double(a.vpls), double(b.vpls), 0.01 * double(a.vpls));
    EXPECT_EQ(a.voxels, b.voxels);
    EXPECT_EQ(a.vpls_offered, b.vpls_offered);
    EXPECT_NEAR(double(a.vpls_accepted), double(b.vpls_accepted), 0.01 * double(a.vpls_accepted));
    EXPECT_NEAR(double(a.photons_stored), double(b.photons_stored), 0.01 * double(a.photons_stored));
    EXPECT_NEAR(double(a.shadow_rays), double(b.shadow_rays), 0.01 * double(a.shadow_rays));
    EXPECT_NEAR(double(a.bounce_rays), double(b.bounce_rays), 0.01 * double(a.bounce_rays));
    EXPECT_EQ(gpu.nan_count() + gpu.infinity_count(), 0u);
}
INSTANTIATE_TEST_SUITE_P(
    BuiltinScenes, GpuSvoManyLights,
    testing::Values(Case{"cornell-box", VplVisibility::Rays},
                    Case{"cornell-box", VplVisibility::Svo, [](SvoManyLightsParams& p) { p.filter = 4; }},
                    Case{"cornell-box-glossy", VplVisibility::Rays, [](SvoManyLightsParams& p) { p.bounces = 2; }},
                    Case{"interior", VplVisibility::Rays, [](SvoManyLightsParams& p) { p.repay = false; }},
                    Case{"cornell-box-spot", VplVisibility::ShadowMaps, [](SvoManyLightsParams& p) { p.clamp_m2 = 0; }},
                    Case{"cornell-box-glass", VplVisibility::None,
                         [](SvoManyLightsParams& p) {
                             p.placement = VplPlacement::Camera;
                             p.bounces = SvoManyLightsParams{}.bounces;
                             p.caustic_photons = 2000;
                             p.caustic_radius_m = 0.1f;
                         }},
                    Case{"cornell-box-glass", VplVisibility::None,
                         [](SvoManyLightsParams& p) {
                             p.bounces = SvoManyLightsParams{}.bounces;
                             p.caustic_photons = 20'000;  // of which more are stored than there is room for at first
                             p.caustic_radius_m = 0.1f;
                         }},
                    Case{"cornell-box", VplVisibility::Rays,
                         [](SvoManyLightsParams& p) { p.placement = VplPlacement::Acceptance, p.bounces = 3; }},
                    Case{"cornell-box-glossy", VplVisibility::Rays,
                         [](SvoManyLightsParams& p) { p.placement = VplPlacement::Metropolis, p.bounces = 3; }},
                    Case{"interior", VplVisibility::NearField, [](SvoManyLightsParams& p) { p.repay = false; }},
                    Case{"cornell-box", VplVisibility::Svo,
                         [](SvoManyLightsParams& p) {
                             p.bounces = 3;
                             p.bounce_tracing = VplBounces::Voxels;
                         }}),
    [](const auto& info) { return test::test_name(info.param.scene, info.index); });

// With subsets and roulette a light more or less moves all that come after it, so means over passes are compared.
TEST(GpuSvoManyLightsMean, IsTheCpus) {
    const Scene scene = test::turned(make_builtin_scene("cornell-box-glossy"));
    const auto change = [](auto settings, uint64_t seed) {
        settings.size = {32, 24};
        settings.seed = seed;
        settings.params.interleave = 4;
        settings.params.roulette = 0.5f;
        settings.params.bounces = 2;
        settings.params.sampler = SamplerKind::Random;
        return settings;
    };
    constexpr uint32_t kPasses = 40;
    const auto cpu =
        test::render_blocks(scene, change(settings_for<SvoManyLights>(kPasses, VplVisibility::Rays), 1), 8);
    const auto gpu = test::render_blocks(test::SceneOnDevice(scene),
                                         change(settings_for<SvoManyLightsGpu>(kPasses, VplVisibility::Rays), 2), 8);
    const test::BlockTest blocks = test::compare_blocks(cpu.blocks, gpu.blocks);
    EXPECT_EQ(blocks.alarms, 0u) << blocks.table();
}

struct Begun {
    Begun(const test::SceneOnDevice& where, const test::RenderSettingsOf<SvoManyLightsGpu>& settings)
        : method(settings.params) {
        method.begin({where.scene, &where.intersector, test::view_of(where.scene, settings), settings.seed, budget,
                      &where.device_scene},
                     stats);
    }
    MemoryBudget budget;
    Stats stats;
    SvoManyLightsGpu method;
};

// Three choices whose pipelines the cases above compile: visibility by voxels, caustic photons (whose radii shrink from
// pass to pass), and lights placed by Markov chains.
TEST(GpuSvoManyLightsPass, IsAPureFunctionOfItsIndexAndNoneWhenCancelled) {
    for (const Case& of :
         {Case{"cornell-box", VplVisibility::Svo},
          Case{"cornell-box-glass", VplVisibility::None, [](SvoManyLightsParams& p) { p.caustic_photons = 2000; }},
          Case{"cornell-box-glossy", VplVisibility::Rays,
               [](SvoManyLightsParams& p) { p.placement = VplPlacement::Metropolis; }}}) {
        SCOPED_TRACE(of.scene);
        const Scene scene = make_builtin_scene(of.scene);
        const test::SceneOnDevice where(scene);
        auto settings = settings_for<SvoManyLightsGpu>(1, of.visibility);
        settings.params.interleave = 2;
        settings.params.roulette = 0.5f;
        of.change(settings.params);
        Begun run(where, settings);
        const auto film_of = [&](std::initializer_list<uint32_t> passes) {
            Film film(settings.size, settings.layers);
            for (const uint32_t pass : passes) {
                run.method.run_pass(pass, run.stats, CancelToken{});
                run.method.expect_pass(pass + 1);
                run.method.resolve(film);
            }
            return film;
        };
        CancelToken cancel;
        cancel.cancel();
        run.method.run_pass(0, run.stats, cancel);
        Film nothing(settings.size, settings.layers);
        run.method.resolve(nothing);
        EXPECT_EQ(nothing.passes(), 0u);
        const Film film = film_of({0, 1});
        EXPECT_EQ(film.passes(), 2u);
        EXPECT_EQ(film_of({0, 1}).pixel_hash(), film.pixel_hash());
        EXPECT_EQ(film_of({1, 0}).pixel_hash(), film.pixel_hash());
    }
}

TEST(GpuSvoManyLightsMemory, IsWhatItSays) {
    for (const char* name : {"cornell-box", "interior"}) {
        SCOPED_TRACE(name);
        const Scene scene = make_builtin_scene(name);
        auto settings = settings_for<SvoManyLightsGpu>(1, VplVisibility::Svo);
        settings.params.vpls = 10'000;
        settings.params.bounces = 2;
        settings.params.clamp_m2 = 0.01f;  // else the device's rays are asked, which belong to the scene
        test::expect_device_bytes_as_estimated(test::SceneOnDevice(scene), settings);
    }
}

// No light, mirrors alone, a sky, nothing at all; and no bounce.
TEST(GpuSvoManyLightsHardScenes, AreAsOnTheCpu) {
    std::vector<test::HardScene> scenes = test::hard_scenes_of_devices();
    ASSERT_EQ(scenes.size(), 4u);
    scenes.push_back(scenes.back());
    scenes.back().name = "no bounce";
    for (const test::HardScene& hard : scenes) {
        auto cpu_settings = settings_for<SvoManyLights>(2, VplVisibility::Svo);
        auto gpu_settings = settings_for<SvoManyLightsGpu>(2, VplVisibility::Svo);
        cpu_settings.size = gpu_settings.size = {16, 12};
        if (hard.name == std::string_view("no bounce")) cpu_settings.params.bounces = gpu_settings.params.bounces = 0;
        const Film cpu = test::render(hard.scene, cpu_settings);
        const Film gpu = test::render(test::SceneOnDevice(hard.scene), gpu_settings);
        const double mean = test::mean_of(cpu.resolve_beauty());
        EXPECT_NEAR(test::mean_of(gpu.resolve_beauty()), mean, 0.003 * mean) << hard.name;
        EXPECT_EQ(gpu.nan_count() + gpu.infinity_count(), 0u) << hard.name;
        EXPECT_TRUE(!hard.dark || test::mean_of(gpu.resolve_beauty()) == 0) << hard.name;
    }
}

}  // namespace
}  // namespace photond::gpu_svo_many_lights_test

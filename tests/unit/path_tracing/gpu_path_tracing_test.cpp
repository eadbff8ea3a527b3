// Path tracing on a GPU against its CPU twin: the same paths, but for rounding; and what a method promises beside.

#include <gtest/gtest.h>

#include "renderer/methods/path_tracing/path_tracing_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_path_tracing_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_for(uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {40, 30};  // tiles cut at both edges
    settings.passes = passes;
    settings.layers = test::path_tracing_layers();
    settings.params.indirect_bounces = 4;
    return settings;
}

struct TwoFilms {
    Film cpu, gpu;
    Stats cpu_stats, gpu_stats;
};

TwoFilms render_both(const Scene& scene, uint32_t passes) {
    Stats cpu_stats, gpu_stats;
    Film cpu = test::render(scene, settings_for<PathTracing>(passes), &cpu_stats);
    Film gpu = test::render(test::SceneOnDevice(scene), settings_for<PathTracingGpu>(passes), &gpu_stats);
    return {std::move(cpu), std::move(gpu), cpu_stats, gpu_stats};
}

class GpuPathTracing : public testing::TestWithParam<const char*> {};

// The same numbers drive both: rounding alone tells them apart, which now and then sends a path elsewhere (a hit on the
// other side of an edge, another lobe). What one such path carries is noise of the image's own size, so the share of
// values that are apart is bounded, not how far: 2 % of 40 x 30 x 3.
TEST_P(GpuPathTracing, FollowsTheCpusPaths) {
    const Scene scene = test::turned(make_builtin_scene(GetParam()));
    const TwoFilms films = render_both(scene, 2);
    for (const Layer layer : {Layer::Emitted, Layer::Direct, Layer::Indirect, Layer::Caustic, Layer::Albedo,
                              Layer::Normal, Layer::Position, Layer::Depth, Layer::GeometricNormal})
        EXPECT_LT(test::share_apart(films.cpu.resolve(layer), films.gpu.resolve(layer), 1e-3), 0.02)
            << GetParam() << ", " << layer_info(layer).name;
    const Counts &cpu = films.cpu_stats.counts, &gpu = films.gpu_stats.counts;
    EXPECT_EQ(cpu.camera_rays, gpu.camera_rays);
    EXPECT_NEAR(double(cpu.bounce_rays), double(gpu.bounce_rays), 0.01 * double(cpu.bounce_rays));
    EXPECT_NEAR(double(cpu.shadow_rays), double(gpu.shadow_rays), 0.01 * double(cpu.shadow_rays) + 10);
    EXPECT_EQ(films.gpu.nan_count() + films.gpu.infinity_count(), 0u);
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuPathTracing,
                         testing::Values("cornell-box", "cornell-box-spot", "cornell-box-glossy", "cornell-box-glass",
                                         "interior"),
                         [](const auto& info) { return test::test_name(info.param, info.index); });

// Paths that go on after the wavefront's last kernel are followed by a thread each.
TEST(GpuPathTracing, AWavefrontMakesTheSameImage) {
    for (const char* name : {"cornell-box", "cornell-box-glass"}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        auto settings = settings_for<PathTracingGpu>(1);
        settings.params.indirect_bounces = std::nullopt;
        MemoryBudget budget;
        const RenderContext context{scene,  &where.intersector, test::view_of(scene, settings), settings.seed,
                                    budget, &where.device_scene};
        const auto render = [&](PathKernels kernels, Stats& stats) {
            settings.params.gpu_kernels = kernels;
            PathTracingGpu method(settings.params);
            method.begin(context, stats);
            Film film(settings.size, settings.layers);
            method.run_pass(0, stats, CancelToken{});
            method.resolve(film);
            return film;
        };
        Stats mega, wave;
        const Film by_thread = render(PathKernels::Mega, mega);
        const Film by_wave = render(PathKernels::Wavefront, wave);
        // The compiler may round one shader unlike the other: as with the CPU's twin, few values are apart.
        for (const LayerInfo& info : kLayers) {
            if (!settings.layers.has(info.layer)) continue;
            EXPECT_LT(test::share_apart(by_thread.resolve(info.layer), by_wave.resolve(info.layer), 1e-4), 0.005)
                << name << ", " << info.name;
        }
        EXPECT_EQ(mega.counts.camera_rays, wave.counts.camera_rays);
        EXPECT_NEAR(double(mega.counts.bounce_rays), double(wave.counts.bounce_rays),
                    0.001 * double(mega.counts.bounce_rays));
        EXPECT_GT(wave.counts.bounce_rays, 0u);
        EXPECT_EQ(by_wave, render(PathKernels::Wavefront, wave)) << "same device, same bits";
    }
}

TEST(GpuPathTracing, SameDeviceSameBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    const auto settings = settings_for<PathTracingGpu>(3);
    EXPECT_EQ(test::render(where, settings).pixel_hash(), test::render(where, settings).pixel_hash());
}

TEST(GpuPathTracing, APassIsAPureFunctionOfItsIndex) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    auto whole = settings_for<PathTracingGpu>(4), first = settings_for<PathTracingGpu>(1),
         rest = settings_for<PathTracingGpu>(3);
    rest.first_pass = 1;
    Film merged = test::render(where, first);
    merged.merge(test::render(where, rest));
    EXPECT_EQ(merged, test::render(where, whole));
}

TEST(GpuPathTracing, ACancelledPassIsNoPass) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    const auto settings = settings_for<PathTracingGpu>(1);
    MemoryBudget budget;
    Stats stats;
    const RenderContext context{scene,  &where.intersector, test::view_of(scene, settings), 1,
                                budget, &where.device_scene};
    PathTracingGpu method(settings.params);
    method.begin(context, stats);
    CancelToken cancel;
    cancel.cancel();
    method.run_pass(0, stats, cancel);
    Film film(settings.size, settings.layers);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 0u);
    method.run_pass(0, stats, CancelToken{});
    method.resolve(film);
    EXPECT_EQ(film, test::render(where, settings));
}

TEST(GpuPathTracing, TakesTheMemoryItSays) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    auto settings = settings_for<PathTracingGpu>(1);
    for (const PathKernels kernels : {PathKernels::Mega, PathKernels::Wavefront}) {
        settings.params.gpu_kernels = kernels;
        test::expect_device_bytes_as_estimated(where, settings);
    }
}

}  // namespace
}  // namespace photond::gpu_path_tracing_test

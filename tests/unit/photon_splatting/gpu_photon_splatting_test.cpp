// Photon splatting on a GPU against its CPU twin: the same photons and visible points, but for rounding; and what a
// method promises beside.

#include <gtest/gtest.h>

#include "renderer/backends/gpu/counters.h"
#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"
#include "renderer/photons/reflected_photons_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_photon_splatting_test {
namespace {

constexpr uint64_t kSeed = 5;

PhotonTracing tracing_for(PhotonInjection injection) {
    return {.photons = 1500,
            .most_scatterings = injection == PhotonInjection::Paths ? 3u : 1u,
            .glossy_threshold = 0.2f,
            .injection = injection};
}

struct PhotonsOfBoth {
    TracedReflections cpu;
    std::vector<ReflectedPhoton> gpu;  // in their order
    Counts gpu_counts;
};

PhotonsOfBoth trace_both(const Scene& scene, PhotonInjection injection) {
    const PhotonTracing tracing = tracing_for(injection);
    const EmissionSampler emission(scene);
    constexpr uint32_t kPass = 3;
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    PhotonsOfBoth photons;
    photons.cpu = PhotonTracer(scene, *intersector, emission, tracing).trace_reflected(kSeed, kPass, CancelToken{});

    const test::SceneOnDevice where(scene);
    gpu::Device& device = test::gpu_device();
    gpu::Counters counters(device);
    ReflectedPhotonsGpu tracer(where.device_scene, emission, tracing, counters.buffer());
    gpu::CommandList commands(device);
    do {
        const uint32_t paths = tracer.start(kSeed, kPass);
        commands.reset();
        counters.record_clear(commands);
        tracer.record_start(commands);
        tracer.record_paths(commands, 0, paths / 2);
        tracer.record_paths(commands, paths / 2, paths);
        tracer.record_order(commands);
        counters.record_readback(commands);
        commands.submit();
        commands.wait();
    } while (tracer.grow_if_short());
    counters.read(photons.gpu_counts);
    const uint32_t count = tracer.photons_of_pass();
    const auto records = gpu::read_back<ReflectedPhoton>(device, tracer.photons(), count);
    for (const uint32_t i : gpu::read_back<uint32_t>(device, tracer.order(), count)) photons.gpu.push_back(records[i]);
    return photons;
}

bool alike(const ReflectedPhoton& a, const ReflectedPhoton& b, float scene_m) {
    const auto near = [](const vec3& x, const vec3& y, float tolerance) { return glm::length(x - y) <= tolerance; };
    return near(a.position, b.position, 1e-4f * scene_m) && near(a.normal, b.normal, 1e-3f) &&
           near(a.direction, b.direction, 2e-3f) && near(a.power_w, b.power_w, 2e-3f * glm::length(a.power_w)) &&
           std::fabs(a.correction - b.correction) < 2e-3f && a.scatterings_and_spread == b.scatterings_and_spread &&
           (a.surface == ReflectedPhoton::kNoSurface) == (b.surface == ReflectedPhoton::kNoSurface);
}

class GpuReflectedPhotons : public testing::TestWithParam<std::tuple<const char*, PhotonInjection>> {};

// Their orders differ, so each looks for its like. Paths that rounding sent elsewhere have none, nor what they left
// after: up to 2 %.
TEST_P(GpuReflectedPhotons, AreTheCpus) {
    const Scene scene = test::turned(make_builtin_scene(std::get<0>(GetParam())));
    const PhotonsOfBoth photons = trace_both(scene, std::get<1>(GetParam()));
    ASSERT_GT(photons.cpu.photons.size(), 500u);
    EXPECT_NEAR(double(photons.gpu.size()), double(photons.cpu.photons.size()), 0.01 * double(photons.gpu.size()));
    size_t alone = 0;
    for (const ReflectedPhoton& photon : photons.gpu)
        alone +=
            std::none_of(photons.cpu.photons.begin(), photons.cpu.photons.end(),
                         [&](const ReflectedPhoton& other) { return alike(photon, other, scene.bounds.radius()); });
    EXPECT_LT(double(alone), 0.02 * double(photons.gpu.size()));
    EXPECT_EQ(photons.cpu.counts.photons_emitted, photons.gpu_counts.photons_emitted);
    EXPECT_EQ(photons.gpu.size(), photons.gpu_counts.photons_stored);
    EXPECT_NEAR(double(photons.cpu.counts.photon_rays), double(photons.gpu_counts.photon_rays),
                0.01 * double(photons.cpu.counts.photon_rays));
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuReflectedPhotons,
                         testing::Values(std::tuple("cornell-box", PhotonInjection::Paths),
                                         std::tuple("cornell-box-glossy", PhotonInjection::Paths),
                                         std::tuple("cornell-box-glass", PhotonInjection::Paths),
                                         std::tuple("interior", PhotonInjection::Paths),
                                         std::tuple("cornell-box-spot", PhotonInjection::ReflectiveShadowMap),
                                         std::tuple("interior", PhotonInjection::ReflectiveShadowMap)),
                         [](const auto& info) { return test::test_name(std::get<0>(info.param), info.index); });

enum class How { Connect, Kernel, Normalised };

template <class M>
test::RenderSettingsOf<M> settings_for(uint32_t passes, How how = How::Connect) {
    test::RenderSettingsOf<M> settings;
    settings.size = {40, 30};  // tiles cut at both edges
    settings.passes = passes;
    settings.layers = test::photon_splatting_layers();
    settings.params.photons = 400;
    settings.params.bounces = 2;
    settings.params.splat_size_relative = 0.4f;
    settings.params.adaptive_size = false;
    settings.params.estimator = how == How::Kernel ? SplatEstimator::Kernel : SplatEstimator::Connect;
    settings.params.weighting = how == How::Normalised ? SplatWeighting::Normalised : SplatWeighting::Radiometric;
    settings.params.shadow_resolution = 8;
    return settings;
}

class GpuPhotonSplatting : public testing::TestWithParam<std::tuple<const char*, How>> {};

// With splats of one size and one ray a photon the same numbers drive both: rounding alone tells them apart. A photon
// that it sends elsewhere changes the sum of every point about its ray, by its share of the hundreds that bring light
// there; so most values agree to a hundredth of the mean, and means to 0.3 %.
TEST_P(GpuPhotonSplatting, FollowsTheCpu) {
    const auto [name, how] = GetParam();
    const Scene scene = test::turned(make_builtin_scene(name));
    Stats cpu_stats, gpu_stats;
    const Film cpu = test::render(scene, settings_for<PhotonSplatting>(2, how), &cpu_stats);
    const Film gpu = test::render(test::SceneOnDevice(scene), settings_for<PhotonSplattingGpu>(2, how), &gpu_stats);
    for (const Layer layer : {Layer::Emitted, Layer::Direct, Layer::Albedo, Layer::Normal, Layer::Depth})
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 1e-3), 0.02) << layer_info(layer).name;
    const std::vector<float> cpu_indirect = cpu.resolve(Layer::Indirect), gpu_indirect = gpu.resolve(Layer::Indirect);
    EXPECT_LT(test::share_apart(cpu_indirect, gpu_indirect, 1e-2), 0.05);
    EXPECT_NEAR(test::mean_of(gpu_indirect) / test::mean_of(cpu_indirect), 1, 3e-3);
    // Of points that are not Lambert the CPU counts also what comes from behind, to no effect.
    if (scene.needs.only_lambert()) {
        EXPECT_NEAR(test::mean_of(gpu.resolve(Layer::Overlap)) / test::mean_of(cpu.resolve(Layer::Overlap)), 1, 5e-3);
    }
    const Counts &a = cpu_stats.counts, &b = gpu_stats.counts;
    EXPECT_EQ(a.camera_rays, b.camera_rays);
    EXPECT_NEAR(double(a.splats), double(b.splats), 0.01 * double(a.splats));
    if (scene.needs.only_lambert()) {
        EXPECT_NEAR(double(a.splat_contributions), double(b.splat_contributions), 0.01 * double(a.splat_contributions));
    }
    EXPECT_EQ(gpu.nan_count() + gpu.infinity_count(), 0u);
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuPhotonSplatting,
                         testing::Values(std::tuple("cornell-box-glossy", How::Connect),
                                         std::tuple("interior", How::Kernel),
                                         std::tuple("cornell-box", How::Normalised)),
                         [](const auto& info) { return test::test_name(std::get<0>(info.param), info.index); });

struct Begun {
    explicit Begun(const test::SceneOnDevice& where, const test::RenderSettingsOf<PhotonSplattingGpu>& settings)
        : method(settings.params) {
        method.begin({where.scene, &where.intersector, test::view_of(where.scene, settings), settings.seed, budget,
                      &where.device_scene},
                     stats);
    }
    MemoryBudget budget;
    Stats stats;
    PhotonSplattingGpu method;
};

// In a glass scene some pixels have many points and some none, and both kinds of splats are there. One method for all:
// its pipelines take a software device seconds.
TEST(GpuPhotonSplatting, APassIsAPureFunctionOfItsIndexAndNoneWhenCancelled) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    auto settings = settings_for<PhotonSplattingGpu>(1);
    settings.size = {20, 15};
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

TEST(GpuPhotonSplatting, TakesTheMemoryItSays) {
    for (const char* name : {"cornell-box", "cornell-box-glass"}) {
        SCOPED_TRACE(name);
        const Scene scene = make_builtin_scene(name);
        auto settings = settings_for<PhotonSplattingGpu>(1);
        settings.params.photons = 10'000;
        test::expect_device_bytes_as_estimated(test::SceneOnDevice(scene), settings);
    }
}

// No light, mirrors alone, a sky, nothing at all.
TEST(GpuPhotonSplatting, HardScenesAreAsOnTheCpu) {
    const std::vector<test::HardScene> scenes = test::hard_scenes_of_devices();
    ASSERT_EQ(scenes.size(), 4u);
    for (const test::HardScene& hard : scenes) {
        auto cpu_settings = settings_for<PhotonSplatting>(2);
        auto gpu_settings = settings_for<PhotonSplattingGpu>(2);
        cpu_settings.size = gpu_settings.size = {16, 12};
        const Film cpu = test::render(hard.scene, cpu_settings);
        const Film gpu = test::render(test::SceneOnDevice(hard.scene), gpu_settings);
        const double mean = test::mean_of(cpu.resolve_beauty());
        EXPECT_NEAR(test::mean_of(gpu.resolve_beauty()), mean, 0.003 * mean) << hard.name;
        EXPECT_EQ(gpu.nan_count() + gpu.infinity_count(), 0u) << hard.name;
        EXPECT_TRUE(!hard.dark || test::mean_of(gpu.resolve_beauty()) == 0) << hard.name;
    }
}

// The least room is for 1024 photons; these are more than expected of a room whose walls take a third of the light.
TEST(GpuPhotonSplatting, MakesRoomForMorePhotonsThanExpected) {
    Scene scene = make_builtin_scene("furnace");
    for (Material& material : scene.materials) material.base_color = Rgb(0.98f);
    const PhotonsOfBoth photons = trace_both(scene, PhotonInjection::Paths);
    ASSERT_GT(photons.cpu.photons.size(), size_t{1500 * 3 * 7 / 10});
    EXPECT_NEAR(double(photons.gpu.size()), double(photons.cpu.photons.size()), 0.05 * double(photons.gpu.size()));
    EXPECT_EQ(photons.gpu.size(), photons.gpu_counts.photons_stored);
}

}  // namespace
}  // namespace photond::gpu_photon_splatting_test

// The radiance cache on a device: as bright as on the CPU, a path tracer where no cell knows enough, and the same bits.

#include <gtest/gtest.h>

#include "renderer/methods/radiance_cache/radiance_cache.h"
#include "renderer/methods/radiance_cache/radiance_cache_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/aged_frames.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"

namespace photond::gpu_radiance_cache_test {
namespace {

constexpr double kStandardErrors = 5.2;  // false alarms 2e-7 a check, of a dozen

template <class M>
test::RenderSettingsOf<M> settings_of(uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {32, 24};
    settings.passes = passes;
    settings.params.cells = 1 << 14;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}
using Settings = test::RenderSettingsOf<RadianceCacheGpu>;

/// Of as many images by seeds of their own, which are independent as passes of a block are not.
test::RunningMean indirect_of_seeds(const test::SceneOnDevice& where, Settings settings, uint32_t seeds,
                                    Stats* stats = nullptr) {
    test::RunningMean mean;
    for (settings.seed = 1; settings.seed <= seeds; ++settings.seed)
        mean.add(test::mean_of_layer(test::render(where, settings, stats), Layer::Indirect));
    return mean;
}

test::RunningMean indirect_on_host(const Scene& scene, test::RenderSettingsOf<RadianceCache> settings, uint32_t seeds) {
    test::RunningMean mean;
    for (settings.seed = 1001; settings.seed <= 1000 + seeds; ++settings.seed)
        mean.add(test::mean_of_layer(test::render(scene, settings), Layer::Indirect));
    return mean;
}

test::RunningMean indirect_by_paths(const Scene& scene, uint32_t passes, std::optional<uint32_t> bounces = {}) {
    test::RenderSettings traced;
    traced.size = {32, 24};
    traced.passes = passes;
    traced.params.indirect_bounces = bounces;
    traced.params.sampler = SamplerKind::Random;
    return test::indirect_of_passes(scene, traced);
}

void expect_same(const test::RunningMean& found, const test::RunningMean& wanted, double most_doubt, const char* what) {
    const double doubt = kStandardErrors * std::hypot(found.standard_error(), wanted.standard_error());
    std::printf("%s: %+.3f %%, %.3f in doubt\n", what, 100 * (found.mean() / wanted.mean() - 1),
                100 * doubt / wanted.mean());
    EXPECT_LT(std::fabs(found.mean() - wanted.mean()), doubt) << what;
    EXPECT_LT(doubt, most_doubt * wanted.mean()) << what << ": too noisy to notice a defect";
}

TEST(GpuRadianceCache, IsAsBrightAsOnTheCpu) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    for (const SecondBounces second : {SecondBounces::Paths, SecondBounces::Cache}) {
        const char* name = second == SecondBounces::Paths ? "by paths" : "by the cache";
        const auto settings = [second](auto of_method) {
            of_method.size = {64, 48};
            of_method.params.second_bounces = second;
            // Paths that end in a cell of few samples spread what those got wrong: a cell is to know more here, so that
            // fewer images tell as much.
            of_method.params.least_samples = second == SecondBounces::Cache ? 128 : 8;
            of_method.params.training = second == SecondBounces::Cache ? 1 : 4;  // of few pixels
            return of_method;
        };
        Stats stats;
        // An image of the host takes a fifteenth of the time of the device's.
        const uint32_t seeds = second == SecondBounces::Cache ? 12 : 8;
        const test::RunningMean device =
            indirect_of_seeds(where, settings(settings_of<RadianceCacheGpu>(1)), seeds, &stats);
        expect_same(device, indirect_on_host(scene, settings(settings_of<RadianceCache>(1)), 6 * seeds), 0.05, name);
        EXPECT_GT(stats.counts.cache_hits, stats.counts.cache_misses / 4) << name;
        EXPECT_EQ(stats.counts.cache_refused, 0u);
    }
}

TEST(GpuRadianceCache, IsAPathTracerWhereNoCellKnowsEnough) {
    struct Case {
        const char* scene;
        uint32_t seeds, passes_of_paths;
        double most_doubt;
    };
    for (const Case& of : {Case{"cornell-box-spot", 4, 450, 0.05},
                           Case{"cornell-box-glossy", 10, 1500, 0.08}}) {  // whose mirrors make bright dots
        const Scene scene = make_builtin_scene(of.scene);
        Settings settings = settings_of<RadianceCacheGpu>(1);
        settings.params.least_samples = 1'000'000;
        settings.params.gather_rays = 16;
        settings.size = {64, 48};
        Stats stats;
        expect_same(indirect_of_seeds(test::SceneOnDevice(scene), settings, of.seeds, &stats),
                    indirect_by_paths(scene, of.passes_of_paths), of.most_doubt, of.scene);
        EXPECT_EQ(stats.counts.cache_hits, 0u);
        EXPECT_GT(stats.counts.cache_misses, 0u);
    }
}

/// Cells hold what is left of the bounces, and are asked at one vertex alone.
TEST(GpuRadianceCache, DoesAsManyBouncesAsItIsTold) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    for (const uint32_t bounces : {1u, 2u}) {
        Settings settings = settings_of<RadianceCacheGpu>(1);
        settings.size = {64, 48};
        settings.params.indirect_bounces = bounces;
        settings.params.cell_size = 0.01f;  // whose bias is far below the doubt
        settings.params.training = 4;
        settings.params.cells = 1 << 17;
        const uint32_t seeds = bounces == 1 ? 10 : 9;
        expect_same(indirect_of_seeds(where, settings, seeds), indirect_by_paths(scene, 1500, bounces), 0.05,
                    bounces == 1 ? "one bounce" : "two bounces");
    }
    Settings settings = settings_of<RadianceCacheGpu>(1);
    settings.params.indirect_bounces = 0;
    EXPECT_EQ(indirect_of_seeds(where, settings, 1).mean(), 0);
}

/// What finds no room is not kept, and paths go on in its place.
TEST(GpuRadianceCache, AFullTableRefusesAndStaysRight) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = settings_of<RadianceCacheGpu>(1);
    settings.params.cells = 64;
    settings.params.cell_size = 0.02f;
    Stats stats;
    expect_same(indirect_of_seeds(where, settings, 28, &stats), indirect_by_paths(scene, 400), 0.05, "64 cells");
    EXPECT_GT(stats.counts.cache_refused, 0u);
}

/// The scene is few of the image's tiles, so that the first of the rounds is often black: what a unit of the sums is
/// follows from a later one.
TEST(GpuRadianceCache, FirstRoundsMayBeBlack) {
    Scene scene = make_builtin_scene("cornell-box");
    Camera& camera = scene.cameras[0];
    camera.yfov *= 3;
    const dvec3 eye(camera.position), aside(camera.right + camera.up);
    camera = look_at_camera(eye, eye + dvec3(camera.forward) - 0.35 * aside, dvec3(camera.up), camera.yfov);
    const auto settings = [](auto of_method) {
        of_method.size = {64, 48};
        of_method.params.training = 1;
        return of_method;
    };
    Stats stats;
    const test::RunningMean device =
        indirect_of_seeds(test::SceneOnDevice(scene), settings(settings_of<RadianceCacheGpu>(1)), 120, &stats);
    EXPECT_GT(stats.counts.cache_hits, stats.counts.cache_misses / 2);
    expect_same(device, indirect_on_host(scene, settings(settings_of<RadianceCache>(1)), 600), 0.06, "black rounds");
}

TEST(GpuRadianceCache, SameBitsTwiceWhereverAPassIsRendered) {
    for (const char* name : {"cornell-box-glossy", "cornell-box-spot"}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        Settings settings = settings_of<RadianceCacheGpu>(5);
        settings.params.second_bounces = SecondBounces::Cache;
        settings.params.cells = 512;
        settings.layers.add(Layer::CacheCells), settings.layers.add(Layer::CacheSamples);
        const Film film = test::render(where, settings);
        EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash()) << name;
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        EXPECT_GT(test::mean_of_layer(film, Layer::CacheCells), 0);
        EXPECT_GT(test::mean_of_layer(film, Layer::CacheSamples), 0);
        // In parts: the cache of passes 3 and 4 is made by whoever renders them.
        settings.passes = 3;
        Film first = test::render(where, settings);
        settings.first_pass = 3, settings.passes = 2;
        first.merge(test::render(where, settings));
        EXPECT_EQ(film.pixel_hash(), first.pixel_hash()) << name;
    }
}

TEST(GpuRadianceCache, AgedFramesAreTheSameWhoeverRendersThem) {
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    const test::SceneOnDevice where(scene);
    Settings settings = test::aged_settings<RadianceCacheGpu>(3);
    settings.params.cells = 512;  // not enough
    MemoryBudget budget;
    const auto frame = [&](const std::string& before) {
        const RenderContext context{scene,  &where.intersector, test::view_of(scene, settings), settings.seed,
                                    budget, &where.device_scene};
        RadianceCacheGpu method(settings.params);
        return test::frame_after(method, context, settings, before);
    };
    const test::FrameOf first = frame({});
    settings.seed = 2;
    const test::FrameOf second = frame(first.left), again = frame(first.left);
    EXPECT_EQ(second.film.pixel_hash(), again.film.pixel_hash());
    EXPECT_EQ(second.left, again.left);
    EXPECT_NE(second.film.pixel_hash(), frame({}).film.pixel_hash()) << "it follows";
    settings.passes = 1;
    test::FrameOf begun = frame(first.left);
    settings.first_pass = 1, settings.passes = 2;
    const test::FrameOf ended = frame(first.left);
    begun.film.merge(ended.film);
    EXPECT_EQ(begun.film.pixel_hash(), second.film.pixel_hash());
    EXPECT_EQ(ended.left, second.left);
}

/// What ages is as bright on both.
TEST(GpuRadianceCache, AgedFramesAreAsBrightAsOnTheCpu) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    constexpr uint32_t kFrames = 3, kChains = 8;
    const auto chains = [&](auto settings, const Intersector* host, const gpu::DeviceScene* device, auto make,
                            uint64_t first_seed) {
        settings.params.training = 1;
        test::RunningMean light;
        for (uint64_t chain = 0; chain < kChains; ++chain) {
            std::string left;
            for (uint32_t frame = 0; frame < kFrames; ++frame) {
                settings.seed = first_seed + 100 * chain + frame;
                const RenderContext context{scene, host, test::view_of(scene, settings), settings.seed, budget, device};
                auto method = make(settings.params);
                const test::FrameOf now = test::frame_after(*method, context, settings, left);
                left = now.left;
                if (frame + 1 == kFrames) light.add(test::mean_of_layer(now.film, Layer::Indirect));
            }
        }
        return light;
    };
    const auto on_device = chains(
        test::aged_settings<RadianceCacheGpu>(1), &where.intersector, &where.device_scene,
        [](const auto& params) { return std::make_unique<RadianceCacheGpu>(params); }, 1);
    const auto on_host = chains(
        test::aged_settings<RadianceCache>(1), intersector.get(), nullptr,
        [](const auto& params) { return std::make_unique<RadianceCache>(params); }, 100'001);
    expect_same(on_device, on_host, 0.2, "aged light");
}

TEST(GpuRadianceCache, NoLightPassesThinWalls) {
    const Scene scene = make_builtin_scene("hard-case/thin-wall-1e-5");
    EXPECT_EQ(indirect_of_seeds(test::SceneOnDevice(scene), settings_of<RadianceCacheGpu>(3), 1).mean(), 0);
}

TEST(GpuRadianceCache, TakesTheDeviceMemoryItSays) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = settings_of<RadianceCacheGpu>(1);
    settings.size = {160, 120};
    settings.params.cells = 1 << 18;
    test::expect_device_bytes_as_estimated(where, settings);
}

}  // namespace
}  // namespace photond::gpu_radiance_cache_test

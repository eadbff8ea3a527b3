// The radiance cache as a method: what does not change its bits, what it keeps and reports, and where paths end in it.

#include "renderer/methods/radiance_cache/radiance_cache.h"
#include "renderer/methods/radiance_cache/cache_training.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::radiance_cache_test {
namespace {

using Cached = test::RenderSettingsOf<RadianceCache>;

Cached cached_settings() {
    Cached settings;
    settings.size = {40, 28};  // tiles cut at both edges
    settings.passes = 3;
    settings.layers.add(Layer::Caustic);
    settings.layers.add(Layer::CacheCells);
    settings.layers.add(Layer::CacheSamples);
    settings.params.training = 1;
    return settings;
}

TEST(RadianceCache, BlocksOfPassesDoubleUpToSixteen) {
    uint32_t next = 0;
    for (const uint32_t passes : {1u, 2u, 4u, 8u, 16u, 16u, 16u}) {
        for (uint32_t pass = next; pass < next + passes; ++pass) {
            EXPECT_EQ(cache_block_of(pass).first, next) << pass;
            EXPECT_EQ(cache_block_of(pass).passes, passes) << pass;
        }
        next += passes;
    }
    const CacheBlock last = cache_block_of(UINT32_MAX);
    EXPECT_LE(UINT32_MAX - last.first, last.passes);
}

TEST(RadianceCache, PixelHashDoesNotDependOnThreads) {
    for (const char* name : {"cornell-box-glossy", "interior"}) {
        const Scene scene = make_builtin_scene(name);
        for (const SecondBounces second_bounces : {SecondBounces::Paths, SecondBounces::Cache}) {
            Cached settings = cached_settings();
            settings.params.second_bounces = second_bounces;
            settings.params.cells = 512;  // not enough
            Stats stats;
            const auto hash = [&](int threads) {
                return test::on_threads(threads, [&] { return test::render(scene, settings, &stats).pixel_hash(); });
            };
            const std::string one = hash(1);
            EXPECT_EQ(one, hash(2)) << name;
            EXPECT_EQ(one, hash(8)) << name;
            EXPECT_GT(stats.counts.cache_hits, 0u);
            EXPECT_GT(stats.counts.cache_refused, 0u);
        }
    }
}

TEST(RadianceCache, APassIsAPureFunctionOfItsIndex) {
    const Scene scene = make_builtin_scene("cornell-box");
    Cached settings = cached_settings();
    settings.passes = 5;
    for (const uint32_t first : {2u, 4u}) {
        Film all(settings.size, settings.layers), last(settings.size, settings.layers, first);
        test::run_passes(scene, settings, [&](RadianceCache& method, uint32_t pass) {
            if (pass == first) method.resolve(last);
        });
        Cached alone = settings;
        alone.first_pass = first;
        alone.passes = 1;
        EXPECT_EQ(last.pixel_hash(), test::render(scene, alone).pixel_hash());
    }
}

TEST(RadianceCache, MemoryIsEstimatedAndBounded) {
    const Scene scene = make_builtin_scene("interior");
    for (const uint32_t cells : {1u << 10, 1u << 16}) {
        Cached settings = cached_settings();
        settings.params.cells = cells;
        MemoryBudget budget;
        test::render(scene, settings, nullptr, &budget);
        const auto estimate =
            static_cast<double>(RadianceCache::estimate_bytes(settings.params, test::workload_of(scene, settings)));
        EXPECT_NEAR(static_cast<double>(budget.accounted_bytes()) / estimate, 1, 0.03);
        MemoryBudget small(static_cast<uint64_t>(estimate / 2));
        EXPECT_THROW(test::render(scene, settings, nullptr, &small), Error);
    }
}

TEST(RadianceCache, EndsMostPathsWhereItIsFullAndNoneWhereItIsNot) {
    const Scene scene = make_builtin_scene("cornell-box");
    Cached settings = cached_settings();
    settings.params.training = 4;
    settings.params.least_samples = 4;
    Stats full, never;
    test::render(scene, settings, &full);
    EXPECT_GT(full.counts.cache_hits, 3 * full.counts.cache_misses);
    settings.params.least_samples = 1'000'000;
    test::render(scene, settings, &never);
    EXPECT_EQ(never.counts.cache_hits, 0u);
    EXPECT_GT(never.counts.bounce_rays, full.counts.bounce_rays);
}

TEST(RadianceCache, WithoutBouncesThereIsNoIndirectLightAndNoCache) {
    const Scene scene = make_builtin_scene("cornell-box");
    Cached settings = cached_settings();
    settings.params.indirect_bounces = 0;
    Stats stats;
    const Film film = test::render(scene, settings, &stats);
    EXPECT_EQ(test::mean_of(film.resolve(Layer::Indirect)), 0);
    EXPECT_GT(test::mean_of(film.resolve(Layer::Direct)), 0);
    EXPECT_EQ(stats.counts.cache_hits + stats.counts.cache_misses, 0u);
    EXPECT_TRUE(std::any_of(stats.skipped.begin(), stats.skipped.end(),
                            [](const Skipped& skipped) { return skipped.what == "radiance cache"; }));
}

TEST(RadianceCache, LayersShowItsCellsAndWhatTheyKnow) {
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    const Film film = test::render(scene, cached_settings());
    EXPECT_GT(test::mean_of(film.resolve(Layer::CacheSamples)), 1);
    const std::vector<float> colours = film.resolve(Layer::CacheCells);
    EXPECT_GT(test::mean_of(colours), 0.3);
    EXPECT_LT(test::mean_of(colours), 0.7);
}

TEST(RadianceCache, ACancelledPassLeavesNothing) {
    const Scene scene = make_builtin_scene("cornell-box");
    const Cached settings = cached_settings();
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const RenderContext context{scene, intersector.get(), test::view_of(scene, settings), 1, budget};
    RadianceCache method(settings.params);
    method.begin(context, stats);
    CancelToken cancelled;
    cancelled.cancel();
    Film film(settings.size, settings.layers);
    method.run_pass(0, stats, cancelled);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 0u);
    method.run_pass(0, stats, CancelToken{});  // whole, as if nothing had been
    method.resolve(film);
    Cached one = settings;
    one.passes = 1;
    EXPECT_EQ(film.pixel_hash(), test::render(scene, one).pixel_hash());
}

}  // namespace
}  // namespace photond::radiance_cache_test

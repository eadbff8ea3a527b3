// What the bidirectional methods promise beside the right light: bits that depend neither on threads nor on where
// passes are rendered, layers, skipped parts, parameters, memory.

#include "renderer/bidirectional/bidirectional_method.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/bidirectional/light_paths.h"
#include "renderer/methods/bidirectional_path_tracing/bidirectional_path_tracing.h"
#include "renderer/methods/registry.h"
#include "renderer/methods/vertex_connection_and_merging/vertex_connection_and_merging.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/render.h"
#include "tests/support/threads.h"

namespace photond::bidirectional_method_test {
namespace {

using Bidirectional = BidirectionalPathTracing;
using Merging = VertexConnectionAndMerging;

template <class M>
test::RenderSettingsOf<M> settings_for(Connections connections = Connections::Cache) {
    test::RenderSettingsOf<M> settings;
    settings.size = {40, 35};  // tiles cut at both edges
    settings.passes = 3;
    settings.params.connections = connections;
    settings.params.adapt = false;
    for (const Layer layer : {Layer::Caustic, Layer::Connections, Layer::LightImage, Layer::Albedo, Layer::Depth})
        settings.layers.add(layer);
    return settings;
}

template <class M>
void expect_the_same_for_any_number_of_threads(Connections connections, PixelFilter filter) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    auto settings = settings_for<M>(connections);
    settings.filter = filter;
    std::vector<std::string> hashes;
    for (const int threads : {1, 2, 8})
        hashes.push_back(test::on_threads(threads, [&] { return test::render(scene, settings).pixel_hash(); }));
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(BidirectionalMethod, PixelHashIsTheSameForAnyNumberOfThreads) {
    expect_the_same_for_any_number_of_threads<Bidirectional>(Connections::Cache, PixelFilter::Gaussian);
    expect_the_same_for_any_number_of_threads<Bidirectional>(Connections::OwnPath, PixelFilter::Box);
    expect_the_same_for_any_number_of_threads<Merging>(Connections::Cache, PixelFilter::Box);
}

TEST(BidirectionalMethod, PassesStandAlone) {
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    auto settings = settings_for<Merging>();
    settings.passes = 4;
    const Film whole = test::render(scene, settings);
    settings.passes = 1;
    Film merged = test::render(scene, settings);
    settings.passes = 3, settings.first_pass = 1;
    merged.merge(test::render(scene, settings));
    EXPECT_EQ(merged.pixel_hash(), whole.pixel_hash());
}

TEST(BidirectionalMethod, LayersAreTheirPartsOfTheLight) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    auto settings = settings_for<Merging>();
    settings.layers.add(Layer::Merges);
    const Film film = test::render(scene, settings);
    const double direct = test::mean_of(film.resolve(Layer::Direct)),
                 indirect = test::mean_of(film.resolve(Layer::Indirect));
    const double connections = test::mean_of(film.resolve(Layer::Connections)),
                 merges = test::mean_of(film.resolve(Layer::Merges)),
                 light_image = test::mean_of(film.resolve(Layer::LightImage)),
                 caustic = test::mean_of(film.resolve(Layer::Caustic));
    for (const double part : {connections, merges, light_image, caustic}) EXPECT_GT(part, 0);
    EXPECT_LT(caustic, indirect);
    EXPECT_LT(connections + merges + light_image, direct + indirect);
}

// One light path a pixel and one connection, as they were not chosen; as many light paths as there are where they are.
TEST(BidirectionalMethod, TechniquesAreShown) {
    auto settings = settings_for<Merging>();
    settings.layers.add(Layer::Techniques);
    settings.passes = 1;
    const std::vector<float> given =
        test::render(make_builtin_scene("cornell-box-glass"), settings).resolve(Layer::Techniques);
    for (size_t i = 0; i < given.size(); i += 3) {
        EXPECT_EQ(given[i], 1);
        EXPECT_EQ(given[i + 1], 0.125f);
        EXPECT_EQ(given[i + 2], 0.5f);
    }
    settings.params.adapt = true;
    settings.size = {96, 96};
    Stats stats;
    const std::vector<float> chosen =
        test::render(make_builtin_scene("keyhole"), settings, &stats).resolve(Layer::Techniques);
    const auto light_paths = static_cast<float>(stats.counts.photons_emitted) / static_cast<float>(chosen.size() / 3);
    EXPECT_GT(light_paths, 0);
    for (size_t i = 0; i < chosen.size(); i += 3) EXPECT_FLOAT_EQ(chosen[i + 2], light_paths / 2);
}

TEST(BidirectionalMethod, WithoutLightPathsThereIsOnlyTheEye) {
    const Scene scene = make_builtin_scene("cornell-box");
    auto settings = settings_for<Bidirectional>();
    settings.params.light_paths = 0;
    Stats stats;
    const Film film = test::render(scene, settings, &stats);
    EXPECT_EQ(stats.counts.photons_emitted, 0u);
    EXPECT_EQ(test::mean_of(film.resolve(Layer::LightImage)), 0);
    EXPECT_GT(test::mean_of(film.resolve(Layer::Indirect)), 0);
    ASSERT_FALSE(stats.skipped.empty());
    EXPECT_EQ(stats.skipped.back().what, "light paths");
}

TEST(BidirectionalMethod, BouncesAreCutWhereTheyAreAskedToBe) {
    const Scene scene = make_builtin_scene("cornell-box");
    auto settings = settings_for<Merging>();
    settings.params.indirect_bounces = 0;
    const Film film = test::render(scene, settings);
    EXPECT_EQ(test::mean_of(film.resolve(Layer::Indirect)), 0);
    EXPECT_EQ(test::mean_of(film.resolve(Layer::Connections)), 0);  // of two surfaces at the least
    EXPECT_GT(test::mean_of(film.resolve(Layer::LightImage)), 0);
}

TEST(BidirectionalMethod, TheCacheIsAsLargeAsItMayBe) {
    const Scene scene = make_builtin_scene("cornell-box");
    auto settings = settings_for<Merging>();
    settings.size = {256, 256};
    settings.passes = 1;
    settings.params.light_paths = 4;
    settings.params.light_cache_mib = 4;
    Stats stats;
    test::render(scene, settings, &stats);
    const uint64_t bytes = stats.counts.photons_stored * (sizeof(LightVertex) + sizeof(PathVertex));
    EXPECT_LE(bytes, 4u << 20);
    EXPECT_GE(bytes, 3u << 20);
}

TEST(BidirectionalMethod, MemoryIsWithinWhatWasSaid) {
    for (const char* name : {"cornell-box", "cornell-box-glass"}) {
        const Scene scene = make_builtin_scene(name);
        const auto expect_within = [&]<class M>(const test::RenderSettingsOf<M>& settings) {
            MemoryBudget budget;
            test::render(scene, settings, nullptr, &budget);
            const auto said =
                static_cast<double>(M::estimate_bytes(settings.params, test::workload_of(scene, settings)));
            EXPECT_LE(static_cast<double>(budget.accounted_bytes()), 1.1 * said) << name;
            EXPECT_GE(static_cast<double>(budget.accounted_bytes()), 0.4 * said) << name;
        };
        auto bidirectional = settings_for<Bidirectional>();
        bidirectional.size = {128, 128};
        expect_within(bidirectional);
        auto merging = settings_for<Merging>();
        merging.size = {128, 128};
        expect_within(merging);
    }
}

TEST(BidirectionalMethod, DarkScenesAreBlack) {
    Scene scene = make_builtin_scene("cornell-box");
    for (Material& material : scene.materials) material.emission = Rgb(0);
    finish_scene(scene);
    const Film film = test::render(scene, settings_for<Merging>());
    EXPECT_EQ(test::mean_of(film.resolve_beauty()), 0);
    EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
}

TEST(BidirectionalMethod, TrainedRadiiAreAFunctionOfTheSeedAlone) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    auto settings = settings_for<Merging>();
    const std::string global = test::render(scene, settings).pixel_hash();
    settings.params.merging_params.radius_rule = RadiusRule::Trained;
    std::vector<std::string> hashes;
    for (const int threads : {1, 8})
        hashes.push_back(test::on_threads(threads, [&] { return test::render(scene, settings).pixel_hash(); }));
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_NE(hashes[0], global);
    settings.params.merging_params.radius_m = 0.1f;
    EXPECT_THROW(settings.params.check(), Error);
}

TEST(BidirectionalMethod, TwoRadiiAreRefused) {
    VertexConnectionAndMergingParams params;
    params.merging_params.radius_m = 0.1f;
    EXPECT_NO_THROW(params.check());
    params.merging_params.radius_relative = 0.1f;
    EXPECT_THROW(params.check(), Error);
}

}  // namespace
}  // namespace photond::bidirectional_method_test

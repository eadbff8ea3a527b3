// Images by the split sum where the answer is known, and what their results say.

#include "renderer/methods/image_based_lighting/image_based_lighting.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "tests/support/environment_scenes.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"

namespace photond::image_based_lighting_test {
namespace {

// Two-sided false alarms of 1e-6 among all checks of this program, two dozen.
constexpr double kMostErrors = 5.4;

template <class M>
test::RenderSettingsOf<M> settings_of(uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {24, 18};
    settings.passes = passes;
    settings.seed = 3;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

test::RenderSettingsOf<ImageBasedLighting> small(uint32_t passes = 1) {
    test::RenderSettingsOf<ImageBasedLighting> settings = settings_of<ImageBasedLighting>(passes);
    settings.params.prefilter_resolution = 64;
    settings.params.prefilter_levels = 5;
    return settings;
}

/// Of the passes: the mean of a layer of each, rendered by itself.
template <class M>
test::RunningMean layer_of_passes(const Scene& scene, const test::RenderSettingsOf<M>& settings, Layer layer) {
    test::RunningMean mean;
    test::run_passes(scene, settings, [&](M& method, uint32_t pass) {
        Film film(settings.size, settings.layers, pass);
        method.resolve(film);
        mean.add(test::mean_of_layer(film, layer));
    });
    return mean;
}

const Skipped* skipped(const Stats& stats, std::string_view what) {
    for (const Skipped& part : stats.skipped)
        if (part.what == what) return &part;
    return nullptr;
}

/// Without noise of its own: each pass of each image is the same but for where pixels are sampled.
TEST(ImageBasedLighting, IsPathTracingInTheOpenUnderAnEvenEnvironment) {
    for (const Material& material : {test::lambert(0.5f), test::coated(Rgb(0.6f, 0.4f, 0.2f), 0.3f),
                                     test::coated(Rgb(1, 0.8f, 0.3f), 0.5f, 1), test::coated(Rgb(0.5f), 0)}) {
        const Scene scene = test::floor_under(material, test::even_environment(Rgb(2, 1, 1)));
        const test::RunningMean split = layer_of_passes(scene, small(16), Layer::Direct);
        test::RenderSettings reference = settings_of<PathTracing>(200);
        reference.params.indirect_bounces = 0;
        const test::RunningMean paths = layer_of_passes(scene, reference, Layer::Direct);
        const double noise = kMostErrors * std::hypot(split.standard_error(), paths.standard_error());
        EXPECT_NEAR(split.mean(), paths.mean(), noise + 0.005 * paths.mean());
        EXPECT_LT(noise, 0.03 * paths.mean()) << "too noisy to notice a defect";
    }
}

/// Lambert reflectors take the irradiance as it is.
TEST(ImageBasedLighting, OfLambertReflectorsInTheOpenIsExactUnderAnyEnvironment) {
    const Scene scene = test::floor_under(test::lambert(0.5f), test::sky_with_sun({64, 32}, 0.2f));
    const test::RunningMean split = layer_of_passes(scene, small(4), Layer::Direct);
    test::RenderSettings reference = settings_of<PathTracing>(400);
    reference.params.indirect_bounces = 0;
    const test::RunningMean paths = layer_of_passes(scene, reference, Layer::Direct);
    const double noise = kMostErrors * std::hypot(split.standard_error(), paths.standard_error());
    EXPECT_NEAR(split.mean(), paths.mean(), noise + 0.005 * paths.mean());
    EXPECT_LT(noise, 0.03 * paths.mean()) << "too noisy to notice a defect";
}

/// Each by itself, and both: neither is counted twice.
TEST(ImageBasedLighting, LightOfLampsAndOfTheEnvironmentAddUp) {
    Scene sky = test::floor_under(test::coated(Rgb(0.5f), 0.5f), test::sky({64, 32})), both = sky;
    test::add_lamp(both);
    Scene lamp = both;
    lamp.environment.reset();
    finish_scene(lamp);
    const test::RunningMean sum = layer_of_passes(both, small(200), Layer::Direct),
                            of_lamp = layer_of_passes(lamp, small(200), Layer::Direct),
                            of_sky = layer_of_passes(sky, small(50), Layer::Direct);
    const double noise =
        kMostErrors * std::hypot(sum.standard_error(), of_lamp.standard_error(), of_sky.standard_error());
    EXPECT_NEAR(sum.mean(), of_lamp.mean() + of_sky.mean(), noise);
    EXPECT_LT(noise, 0.05 * of_lamp.mean()) << "too noisy to notice a defect";
    EXPECT_LT(noise, 0.05 * of_sky.mean()) << "too noisy to notice a defect";
}

/// In gloss too narrow for light samples the lobe's own ray finds them.
TEST(ImageBasedLighting, LampsInGlossAreAsPathTracingHasThem) {
    for (const float roughness : {0.05f, 0.3f}) {
        Scene scene = test::floor_under(test::coated(Rgb(0.5f), roughness), test::sky({8, 4}));
        scene.environment.reset();
        test::add_lamp(scene);
        test::RenderSettings reference = settings_of<PathTracing>(150);
        reference.params.indirect_bounces = 0;
        const test::RunningMean paths = layer_of_passes(scene, reference, Layer::Direct),
                                split = layer_of_passes(scene, small(150), Layer::Direct);
        const double noise = kMostErrors * std::hypot(split.standard_error(), paths.standard_error());
        EXPECT_NEAR(split.mean(), paths.mean(), noise);
        EXPECT_LT(noise, 0.03 * paths.mean()) << "too noisy to notice a defect";
        EXPECT_LT(split.variance(), 2 * paths.variance()) << "narrow gloss is left to light samples";
    }
}

/// A point light leaves nothing to chance, but which of its lobes a path follows at a coat that is a mirror.
TEST(ImageBasedLighting, WithoutAnEnvironmentIsDirectLight) {
    Scene scene = test::balls_under(test::sky({8, 4}));
    scene.environment.reset();
    finish_scene(scene);
    test::RenderSettings reference = settings_of<PathTracing>(4);
    reference.params.indirect_bounces = 0;
    const std::vector<float> paths = test::render(scene, reference).resolve(Layer::Direct),
                             split = test::render(scene, small(4)).resolve(Layer::Direct);
    EXPECT_GT(test::mean_of(paths), 0);
    EXPECT_LT(test::share_apart(paths, split, 1e-4), 0.05);

    Stats stats;
    MemoryBudget budget;
    test::render(scene, small(), &stats, &budget);
    const Skipped* maps = skipped(stats, "prefiltered environment");
    ASSERT_TRUE(maps);
    EXPECT_EQ(maps->why, "the scene has no environment");
    EXPECT_EQ(maps->bytes_saved, PrefilteredEnvironment::bytes_for(prefilter_of(small().params)));
    EXPECT_EQ(budget.structures().count("prefiltered_environment"), 0u);
    for (const Stage& stage : stats.stages) EXPECT_NE(stage.name, "prefilter");
}

/// Emitted light is what other methods see, mirrors and glass included; nothing bounces; and the result says so.
TEST(ImageBasedLighting, SeesTheEnvironmentAndLeavesOutWhatItSays) {
    const Scene scene = test::balls_under(test::sky({64, 32}));
    Stats stats;
    const Film film = test::render(scene, small(4), &stats);
    for (const float value : film.resolve(Layer::Indirect)) ASSERT_EQ(value, 0);
    for (const char* what : {"indirect light", "visibility of the environment", "environment through rough solids"}) {
        ASSERT_TRUE(skipped(stats, what)) << what;
        EXPECT_FALSE(skipped(stats, what)->why.empty());
    }
    const test::RunningMean seen = layer_of_passes(scene, small(100), Layer::Emitted),
                            paths = layer_of_passes(scene, settings_of<PathTracing>(100), Layer::Emitted);
    const double noise = kMostErrors * std::hypot(seen.standard_error(), paths.standard_error());
    EXPECT_NEAR(seen.mean(), paths.mean(), noise);
    EXPECT_LT(noise, 0.1 * paths.mean()) << "too noisy to notice a defect";
}

TEST(ImageBasedLighting, TakesTheMemoryThatItSays) {
    for (const Size2 size : {Size2{64, 32}, Size2{2048, 1024}}) {
        const Scene scene = test::floor_under(test::lambert(0.5f), test::sky(size));
        MemoryBudget budget;
        test::render(scene, small(), nullptr, &budget);
        const uint64_t estimate = ImageBasedLighting::estimate_bytes(small().params, test::workload_of(scene, small()));
        EXPECT_NEAR(double(budget.accounted_bytes()) / double(estimate), 1, 0.05);
        MemoryBudget little(estimate / 2);
        EXPECT_THROW(test::render(scene, small(), nullptr, &little), Error);
    }
}

TEST(ImageBasedLighting, RefusesAResolutionThatIsNoPowerOfTwo) {
    ImageBasedLightingParams params;
    EXPECT_NO_THROW(params.check());
    params.prefilter_resolution = 96;
    EXPECT_THROW(params.check(), Error);
}

}  // namespace
}  // namespace photond::image_based_lighting_test

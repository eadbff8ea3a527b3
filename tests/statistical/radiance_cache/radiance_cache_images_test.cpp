// The radiance cache against path tracing: the same estimator where no cell knows enough, the right light where cells
// blur nothing, and a bias that falls with the cells where they do.

#include <gtest/gtest.h>

#include "renderer/methods/radiance_cache/radiance_cache.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/path_render.h"

namespace photond::radiance_cache_images_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_of(uint64_t seed, uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {32, 32};
    settings.passes = passes;
    settings.seed = seed;
    settings.params.sampler = SamplerKind::Random;  // passes are independent
    return settings;
}

struct Choice {
    const char* scene;
    std::optional<uint32_t> bounces;
};

class RadianceCacheImages : public testing::TestWithParam<Choice> {};

// False alarms: 1e-6 a choice.
TEST_P(RadianceCacheImages, ArePathTracingsWhereNoCellKnowsEnough) {
    const Scene scene = make_builtin_scene(GetParam().scene);
    test::RenderSettings paths = settings_of<PathTracing>(1, 96);
    auto cached = settings_of<RadianceCache>(2, 96);
    paths.params.indirect_bounces = cached.params.indirect_bounces = GetParam().bounces;
    cached.params.least_samples = 1'000'000;
    cached.params.training = 0.01f;
    // No cell is ever used, so passes do not depend on earlier ones.
    const test::ComparedRenders found =
        test::compare_blocks_when_sharp(scene, paths, scene, cached, {.side = 8, .must_notice = 0.35});
    std::printf("%u passes: %s", found.passes, found.test.table(2).c_str());
    EXPECT_EQ(found.test.alarms, 0u) << found.test.table();
    EXPECT_LE(found.test.half_notice, 0.35) << "too noisy to notice a defect";
}
INSTANTIATE_TEST_SUITE_P(Choices, RadianceCacheImages,
                         testing::Values(Choice{"cornell-box", {}}, Choice{"cornell-box-glossy", {}},
                                         Choice{"cornell-box-glass", 3}),
                         [](const auto& info) { return "Choice" + std::to_string(info.index); });

/// The mean of the image over many seeds, each its own cache, over what it should be.
template <class Render>
test::Interval mean_over_seeds(double expected, double narrow, const Render& render, size_t most = 40) {
    return test::interval_when_narrow(narrow, most, 1e-6, 1, [&](uint64_t seed) { return render(seed) / expected; });
}

// Radiance is the same everywhere: cells blur nothing, whatever their size, and all bounces are in them.
void expect_furnace(SecondBounces second_bounces, uint32_t side, double must_detect, size_t most_seeds = 40) {
    const Scene scene = make_builtin_scene("furnace");  // 1 / (1 - 0.5) everywhere
    const auto mean_of_seed = [&](uint64_t seed) {
        auto settings = settings_of<RadianceCache>(seed, 7);
        settings.size = {side, side};
        settings.params.training = 4;
        settings.params.gather_rays = 1;
        settings.params.second_bounces = second_bounces;
        return test::mean_of(test::render(scene, settings).resolve_beauty());
    };
    const test::Interval mean = mean_over_seeds(2, 0.9 * must_detect, mean_of_seed, most_seeds);
    std::printf("furnace, second bounces %d: %.5f +- %.5f\n", int(second_bounces), mean.mean, mean.half_width);
    EXPECT_LE(std::abs(mean.mean - 1), mean.half_width);
    EXPECT_LE(mean.half_width, must_detect) << "too noisy to notice a defect";
}

TEST(RadianceCacheFurnace, IsRightWithinTwoPercent) {
    for (const SecondBounces second_bounces : {SecondBounces::Paths, SecondBounces::Cache})
        expect_furnace(second_bounces, 32, 0.02);
}

TEST(RadianceCacheFurnace, LongIsRightWithinThreePerMille) {
    for (const SecondBounces second_bounces : {SecondBounces::Paths, SecondBounces::Cache})
        expect_furnace(second_bounces, 160, 0.003, 256);
}

// Of a given number of bounces cells hold what is left of them: no more, and no less.
TEST(RadianceCacheFurnace, HoldsAsManyBouncesAsItIsAskedFor) {
    constexpr double kMustDetect = 0.01;
    const Scene scene = make_builtin_scene("furnace");
    for (const uint32_t bounces : {1u, 2u, 4u}) {
        double expected = 2;  // emitted, and scattered once, twice ...: 1 + 1/2 + 1/4 ...
        expected -= std::pow(0.5, bounces + 1);
        const test::Interval mean = mean_over_seeds(expected, 0.4 * kMustDetect, [&](uint64_t seed) {
            auto settings = settings_of<RadianceCache>(seed, 3);
            settings.params.indirect_bounces = bounces;
            settings.params.training = 2;
            return test::mean_of(test::render(scene, settings).resolve_beauty());
        });
        std::printf("furnace, %u bounces: %.5f +- %.5f\n", bounces, mean.mean, mean.half_width);
        EXPECT_LE(std::abs(mean.mean - 1), mean.half_width);
        EXPECT_LE(mean.half_width, kMustDetect) << "too noisy to notice a defect";
    }
}

}  // namespace
}  // namespace photond::radiance_cache_images_test

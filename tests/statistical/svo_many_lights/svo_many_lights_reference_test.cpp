// Many lights against an independent renderer's image of one bounce in the diffuse Cornell box (tests/data/reference):
// where rays answer for V and short rays repay the clamp, no bias, neither of the whole nor of the strips along edges;
// without the clamp none of the whole, as variance at corners is infinite then; and what voxels put in the place of
// rays take, which must fall as they become finer.
//
// Pictures are smaller than the reference: squares of its pixels are averaged, which is what its box filter would have
// given (reduced()).

#include <gtest/gtest.h>

#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/reference_regions.h"

namespace photond::svo_many_lights_reference_test {
namespace {

using test::Mask;
using Settings = test::RenderSettingsOf<SvoManyLights>;

constexpr double kFalseAlarm = 1e-6;  // of all checks of this file together, short and long
constexpr size_t kChoices = 3, kUnclampedChecks = 3, kVoxelChecks = 4 * 3, kTakenChecks = 3;
constexpr size_t kBiasChecks = (kChoices + 1) * test::kReferenceRegions * 3;
constexpr double kShare = kFalseAlarm / (2 * (kBiasChecks + kUnclampedChecks + kVoxelChecks) + kTakenChecks);
constexpr double kAllowed = 3e-3;  // of the whole picture's mean

Settings by_rays(uint32_t side, uint32_t passes) {
    Settings settings;
    settings.size = {side, side};
    settings.passes = passes;
    settings.params.visibility = VplVisibility::Rays;
    settings.params.bounces = 1;
    return settings;
}

struct BiasPlan {
    uint32_t side, films, passes;  // films of so many passes
    double must_notice;            // relative, in the mean of the whole picture; ten times as much in a strip
    bool allow_noise;              // beside the 0.3 % that are asked for, in the whole picture
};

void expect_unbiased(VplChoice choice, const BiasPlan& plan) {
    const Scene scene = make_builtin_scene("cornell-box");
    const std::vector<test::Region> regions = test::regions_of(scene, plan.side);
    ASSERT_EQ(regions.size(), test::kReferenceRegions);
    const std::vector<Mask> masks = test::masks_of(regions);
    Settings settings = by_rays(plan.side, plan.passes);
    settings.params.vpl_choice = choice;
    const auto biases = test::relative_biases(scene, settings, plan.films, test::one_bounce(plan.side), masks, kShare);
    for (size_t r = 0; r < regions.size(); ++r) {
        const bool whole = masks[r].empty();
        EXPECT_TRUE(whole || test::count_of(masks[r]) > 50) << regions[r].name;
        std::printf("  %-26s", regions[r].name);
        for (const test::RelativeBias& bias : biases[r]) {
            std::printf("  %+.3f %% (standard error %.3f %%)", 100 * bias.value, 100 * bias.standard_error);
            EXPECT_LE(std::abs(bias.value), whole ? kAllowed + (plan.allow_noise ? bias.noise : 0) : bias.noise)
                << regions[r].name;
            EXPECT_LE(bias.noise, whole ? plan.must_notice : 10 * plan.must_notice)
                << regions[r].name << ": too noisy to notice a defect";
        }
        std::printf("\n");
    }
}

constexpr BiasPlan kShortPlan{64, 24, 1, 0.03, true}, kLongPlan{128, 64, 16, 0.005, false};

TEST(SvoManyLightsReference, InterleavedLightsAreUnbiased) { expect_unbiased(VplChoice::Interleaved, kShortPlan); }
TEST(SvoManyLightsReference, LightcutsAreUnbiased) { expect_unbiased(VplChoice::Lightcut, kShortPlan); }
TEST(SvoManyLightsReference, ResampledLightsAreUnbiased) { expect_unbiased(VplChoice::Resampled, kShortPlan); }
TEST(SvoManyLightsReferenceLong, InterleavedLightsAreUnbiased) { expect_unbiased(VplChoice::Interleaved, kLongPlan); }

/// Of the whole alone: at corners a pixel's variance is infinite.
TEST(SvoManyLightsReference, WithoutAClampTheWholeIsUnbiased) {
    constexpr double kUnclampedAllowed = 0.01;
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = by_rays(64, 1);
    settings.params.clamp_m2 = 0;
    const auto biases = test::relative_biases(scene, settings, 48, test::one_bounce(64), {{}}, kShare);
    for (const test::RelativeBias& bias : biases[0]) {
        std::printf("  %+.3f %% (standard error %.3f %%)\n", 100 * bias.value, 100 * bias.standard_error);
        EXPECT_LE(std::abs(bias.value), kUnclampedAllowed + bias.noise);
    }
}

/// What the layer `clamped` says is what is missing without `repay`.
TEST(SvoManyLightsReference, TheClampTakesWhatItsLayerSays) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = by_rays(32, 2);
    settings.params.vpls = 128;  // few, so that much is clamped
    settings.layers.add(Layer::Clamped);
    std::vector<double> taken[3];
    for (settings.seed = 1; settings.seed <= 40; ++settings.seed) {
        settings.params.repay = true;
        const std::vector<float> whole = test::render(scene, settings).resolve(Layer::Indirect);
        settings.params.repay = false;
        const Film film = test::render(scene, settings);
        const std::vector<float> clamped = film.resolve(Layer::Indirect), layer = film.resolve(Layer::Clamped);
        for (size_t i = 0; i < whole.size(); ++i) ASSERT_NEAR(whole[i], clamped[i] + layer[i], 1e-5f * (1 + whole[i]));
        for (size_t c = 0; c < 3; ++c)
            taken[c].push_back(test::masked_mean(layer, c, {}) / test::masked_mean(whole, c, {}));
    }
    for (const std::vector<double>& of_channel : taken) {
        const test::Interval interval = test::mean_interval(of_channel, kShare, 1);
        std::printf("the clamp takes %.2f %% +- %.2f %%\n", 100 * interval.mean, 100 * interval.half_width);
        EXPECT_GT(interval.mean - interval.half_width, 0.01);
    }
}

/// Voxels are conservative: they darken, the less the finer they are.
void expect_voxels_to_converge(const std::vector<uint32_t>& resolutions, const BiasPlan& plan, double finest_allowed) {
    const Scene scene = make_builtin_scene("cornell-box");
    double before = 1;
    for (const uint32_t resolution : resolutions) {
        Settings settings = by_rays(plan.side, plan.passes);
        settings.params.visibility = VplVisibility::Svo;
        settings.params.voxel_resolution = resolution;
        const auto biases =
            test::relative_biases(scene, settings, plan.films, test::one_bounce(plan.side), {{}}, kShare);
        double worst = 0;
        std::printf("  %u^3:", resolution);
        for (const test::RelativeBias& bias : biases[0]) {
            std::printf("  %+.3f %% (standard error %.3f %%)", 100 * bias.value, 100 * bias.standard_error);
            EXPECT_LE(bias.noise, plan.must_notice) << "too noisy to judge";
            worst = std::max(worst, std::abs(bias.value));
            EXPECT_LE(std::abs(bias.value), before + bias.noise) << resolution;
        }
        std::printf("\n");
        before = worst;
    }
    EXPECT_LE(before, finest_allowed);
}

TEST(SvoManyLightsReference, VoxelsTakeLessTheFinerTheyAre) {
    expect_voxels_to_converge({32, 128, 512}, kShortPlan, 0.03);
}

}  // namespace
}  // namespace photond::svo_many_lights_reference_test

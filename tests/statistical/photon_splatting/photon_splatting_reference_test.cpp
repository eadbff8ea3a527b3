// Splats that connect, against an independent renderer's image of one bounce in the diffuse Cornell box
// (tests/data/reference): no bias for any splat size, neither of the whole nor of the strips along edges, where the
// clamp takes light and short rays repay it; and a noise that falls as one over the root of the photons, without a
// floor.
//
// Sizes a factor 4 apart: 0.5 m and 2 m in a room of 5.5 m, so that the second spans a third of a wall.
// Bias is judged of splats that adapt to the density of light, as they do unless told otherwise, the fall of the noise
// of splats of one size. Pictures are smaller than the reference where that is cheaper: squares of its pixels are
// averaged, which is what its box filter would have given (reduced()).

#include <gtest/gtest.h>

#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/convergence.h"
#include "tests/support/reference_bias.h"
#include "tests/support/reference_regions.h"

namespace photond::photon_splatting_reference_test {
namespace {

using test::Mask;
using Settings = test::RenderSettingsOf<PhotonSplatting>;

constexpr double kFalseAlarm = 1e-6;  // of all checks of this file together, short and long
constexpr float kSmall = 0.5f, kLarge = 2;
constexpr size_t kRegions = test::kReferenceRegions;
constexpr size_t kBiasChecks = 2 * kRegions * 3, kRepayChecks = 3, kSlopeChecks = 2 * 2;
constexpr double kShare = kFalseAlarm / (2 * (kBiasChecks + kSlopeChecks) + kRepayChecks);

Settings settings_of(float splat_size_m, uint32_t side, uint32_t photons) {
    Settings settings;
    settings.size = {side, side};
    settings.params.splat_size_m = splat_size_m;
    settings.params.photons = photons;
    settings.params.bounces = 1;  // as the reference has
    return settings;
}

struct BiasPlan {
    float splat_size_m;
    uint32_t side, films, passes;  // films of so many passes of 20,000 photons
    double must_notice;            // relative, in the mean of the whole picture; ten times as much in a strip
    bool allow_noise;              // beside the 0.3 % that are asked for, in the whole picture
};

void expect_unbiased(const BiasPlan& plan) {
    constexpr double kAllowed = 3e-3;
    const Scene scene = make_builtin_scene("cornell-box");
    const std::vector<test::Region> regions = test::regions_of(scene, plan.side);
    ASSERT_EQ(regions.size(), kRegions);
    const std::vector<Mask> masks = test::masks_of(regions);
    Settings settings = settings_of(plan.splat_size_m, plan.side, 20'000);
    settings.passes = plan.passes;
    const auto biases = test::relative_biases(scene, settings, plan.films, test::one_bounce(plan.side), masks, kShare);
    std::printf("splat size %g m, %ux%u, %u films of %u passes\n", double{plan.splat_size_m}, plan.side, plan.side,
                plan.films, plan.passes);
    for (size_t r = 0; r < kRegions; ++r) {
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

TEST(PhotonSplattingReference, SmallSplatsThatConnectAreUnbiased) { expect_unbiased({kSmall, 64, 32, 1, 0.03, true}); }
TEST(PhotonSplattingReference, LargeSplatsThatConnectAreUnbiased) { expect_unbiased({kLarge, 64, 32, 1, 0.03, true}); }
TEST(PhotonSplattingReferenceLong, SmallSplatsThatConnectAreUnbiased) {
    expect_unbiased({kSmall, 128, 64, 8, 0.005, false});
}
TEST(PhotonSplattingReferenceLong, LargeSplatsThatConnectAreUnbiased) {
    expect_unbiased({kLarge, 64, 64, 16, 0.005, false});
}

/// What the long runs would notice in the strips: the same photons, with and without what repays the clamp.
TEST(PhotonSplattingReference, WithoutRepaymentStripsAlongEdgesAreDark) {
    constexpr double kNoticed = 0.01;  // relative
    const Scene scene = make_builtin_scene("cornell-box");
    const std::vector<float> expected = test::one_bounce(64).indirect;
    const Mask strip = test::regions_of(scene, 64)[3].mask;
    Settings settings = settings_of(kLarge, 64, 500);
    settings.passes = 6;
    std::vector<double> taken[3];
    for (settings.seed = 1; settings.seed <= 20; ++settings.seed) {
        settings.params.repay = true;
        const std::vector<float> whole = test::render(scene, settings).resolve(Layer::Indirect);
        settings.params.repay = false;
        const std::vector<float> clamped = test::render(scene, settings).resolve(Layer::Indirect);
        for (size_t c = 0; c < 3; ++c)
            taken[c].push_back((test::masked_mean(whole, c, strip) - test::masked_mean(clamped, c, strip)) /
                               test::masked_mean(expected, c, strip));
    }
    for (const std::vector<double>& of_channel : taken) {
        const test::Interval interval = test::mean_interval(of_channel, kShare, 1);
        std::printf("within 0.2 m of edges the clamp takes %.2f %% +- %.2f %%\n", 100 * interval.mean,
                    100 * interval.half_width);
        EXPECT_GT(interval.mean - interval.half_width, kNoticed);
    }
}

struct SlopePlan {
    uint32_t side, photons, first, last;  // photons a pass; passes
    size_t seeds;
    double must_notice;  // a floor of so much of the mean, in RMSE
};

/// RMSE against photons, with independent numbers. The mean squared error of films of n passes is exactly V/n + B for
/// V a pass's variance and B the squared bias of the pixels: the slope is that of the logarithm, B comes from n first
/// and last. The reference's own squared noise is subtracted.
void expect_no_floor(float splat_size_m, const SlopePlan& plan) {
    const Scene scene = make_builtin_scene("cornell-box");
    const std::vector<float> expected = test::one_bounce(plan.side).indirect;
    const double reference_rmse = test::reference_noise_of_mean(Mask(1, 1), plan.side * plan.side);
    const double mean = test::mean_of(expected), relative = 1e6 / (mean * mean);
    std::vector<double> slopes, floors;
    double last_rmse = 0;
    for (size_t seed = 1; seed <= plan.seeds; ++seed) {
        Settings settings = settings_of(splat_size_m, plan.side, plan.photons);
        settings.params.sampler = SamplerKind::Random;
        settings.params.adaptive_size = false;
        settings.passes = plan.last;
        settings.seed = seed;
        const std::vector<double> mse =
            test::errors_of_doubled_passes(scene, settings, plan.first, [&](const Film& film) {
                return test::masked_mse(film.resolve(Layer::Indirect), expected, {}) - reference_rmse * reference_rmse;
            });
        slopes.push_back(0.5 * test::slope_over_doublings(mse));
        floors.push_back((plan.last * mse.back() - plan.first * mse.front()) / (plan.last - plan.first));
        last_rmse = std::sqrt(mse.back());
    }
    const test::Interval slope = test::mean_interval(slopes, kShare, 1), floor = test::mean_interval(floors, kShare, 1);
    std::printf(
        "splat size %g m, %u to %u photons: RMSE slope %.4f +- %.4f, floor^2 (%.2f +- %.2f) e-6 of the squared "
        "mean, RMSE at the end %.2f %% of the mean\n",
        double{splat_size_m}, plan.first * plan.photons, plan.last * plan.photons, slope.mean, slope.half_width,
        relative * floor.mean, relative * floor.half_width, 100 * last_rmse / mean);
    EXPECT_NEAR(slope.mean, -0.5, 0.05);
    EXPECT_LE(slope.half_width, 0.05) << "too noisy to judge";
    EXPECT_LE(floor.mean, floor.half_width);
    EXPECT_LE(std::sqrt(2 * floor.half_width), plan.must_notice * mean) << "too noisy to notice a floor";
}

constexpr SlopePlan kShortSlope{32, 1000, 1, 64, 16, 0.15}, kLongSlope{32, 5000, 4, 512, 20, 0.04};

TEST(PhotonSplattingReference, ErrorOfSmallSplatsFallsWithoutAFloor) { expect_no_floor(kSmall, kShortSlope); }
TEST(PhotonSplattingReference, ErrorOfLargeSplatsFallsWithoutAFloor) { expect_no_floor(kLarge, kShortSlope); }
TEST(PhotonSplattingReferenceLong, ErrorOfSmallSplatsFallsWithoutAFloor) { expect_no_floor(kSmall, kLongSlope); }
TEST(PhotonSplattingReferenceLong, ErrorOfLargeSplatsFallsWithoutAFloor) { expect_no_floor(kLarge, kLongSlope); }

}  // namespace
}  // namespace photond::photon_splatting_reference_test

// What the table of hard cases decides by: quantiles against the tests' own, coverage and power of the verdicts, and
// regions of images.

#include "clients/cli/hard_cases_verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clients/cli/failure.h"
#include "clients/cli/hard_cases_pixels.h"
#include "clients/cli/hard_cases_scenes.h"
#include "tests/support/statistics.h"

namespace photond::cli::hard_cases_verdict_test {
namespace {

/// Seeds that scatter about `truth` times (1 + bias), by `noise` of it.
RegionSamples noisy(const Radiance& truth, double bias, double noise, size_t seeds, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    RegionSamples samples;
    for (size_t i = 0; i < seeds; ++i) {
        Radiance mean;
        for (size_t c = 0; c < kChannels; ++c) mean[c] = truth[c] * (1 + bias + noise * normal(random));
        samples.means.push_back(mean);
        samples.answers.push_back(truth);
    }
    return samples;
}

constexpr Radiance kGrey = {0.5, 0.25, 2};

TEST(HardCaseQuantile, AgreesWithTheIncompleteBetaFunction) {
    for (const size_t degrees : {1U, 2U, 3U, 5U, 7U, 8U, 23U})
        for (const double probability : {0.3, 0.05, 1e-4, 1e-8})
            EXPECT_NEAR(
                two_sided_t(probability, degrees) / test::two_sided_t(probability, static_cast<double>(degrees)), 1,
                1e-5)
                << degrees << " degrees, " << probability;
    EXPECT_NEAR(shared_false_alarm(1e-6, 100), test::share_of_false_alarm(1e-6, 100), 1e-18);
}

TEST(HardCaseVerdict, AWrongAnswerIsFoundWhoeverGivesIt) {
    std::mt19937_64 random(1);
    const double alarm = shared_false_alarm(kTableFalseAlarm, 300);
    RegionSamples samples = noisy(kGrey, 0, 1e-3, 8, random);
    EXPECT_TRUE(judge(Relation::Equals, samples, alarm).holds);
    for (const size_t wrong : {0U, 1U, 2U}) {  // in one channel alone
        RegionSamples off = samples;
        for (Radiance& answer : off.answers) answer[wrong] *= 1.05;
        const Judgement judgement = judge(Relation::Equals, off, alarm);
        EXPECT_FALSE(judgement.holds);
        EXPECT_EQ(judgement.channel, wrong);
        EXPECT_NEAR(judgement.bias, -0.05 / 1.05, 5e-3);
        EXPECT_LT(judgement.half_width, 0.03);
        EXPECT_EQ(verdict_text(judgement), "breaks");
    }
}

TEST(HardCaseVerdict, AlarmsAreFalseAsOftenAsStated) {
    // One channel of the three decides alone: the others are exact. 4,000 tables at 5 %: 200 +- 14 alarms, and a count
    // outside of 129 to 271 has a chance of 1e-6.
    std::mt19937_64 random(2);
    for (const Relation relation : {Relation::Equals, Relation::AtMost}) {
        size_t alarms = 0;
        for (int i = 0; i < 4000; ++i) {
            RegionSamples samples = noisy(kGrey, 0, 0.1, 6, random);
            for (Radiance& mean : samples.means) mean[0] = kGrey[0], mean[1] = kGrey[1];
            alarms += !judge(relation, samples, 0.05).holds;
        }
        EXPECT_GT(alarms, 129U) << wire_name(relation);
        EXPECT_LT(alarms, 271U) << wire_name(relation);
    }
}

TEST(HardCaseVerdict, ABoundIsBrokenFromAboveOnly) {
    std::mt19937_64 random(3);
    EXPECT_TRUE(judge(Relation::AtMost, noisy(kGrey, -0.5, 1e-3, 8, random), 1e-6).holds);
    EXPECT_FALSE(judge(Relation::AtMost, noisy(kGrey, 0.05, 1e-3, 8, random), 1e-6).holds);
    EXPECT_FALSE(judge(Relation::Equals, noisy(kGrey, -0.5, 1e-3, 8, random), 1e-6).holds);
}

TEST(HardCaseVerdict, PairsThatShareTheirNoiseAreComparedWithoutIt) {
    std::mt19937_64 random(4);
    RegionSamples samples = noisy(kGrey, 0, 0.2, 6, random);
    samples.answers = samples.means;  // the same image, as far from the truth as noise takes it
    EXPECT_TRUE(judge(Relation::SameAs, samples, 1e-9).holds);
    for (Radiance& mean : samples.means)
        for (double& channel : mean) channel *= 1.001;
    const Judgement judgement = judge(Relation::SameAs, samples, 1e-3);
    EXPECT_FALSE(judgement.holds);
    EXPECT_NEAR(judgement.bias, 1e-3, 1e-9);
}

TEST(HardCaseVerdict, TheAnswersOwnToleranceIsGranted) {
    std::mt19937_64 random(5);
    RegionSamples samples = noisy(kGrey, 0.02, 1e-5, 8, random);
    EXPECT_FALSE(judge(Relation::Equals, samples, 1e-6).holds);
    samples.tolerance = 0.021;
    EXPECT_TRUE(judge(Relation::Equals, samples, 1e-6).holds);
}

TEST(HardCaseVerdict, NoiseThatHidesAnErrorIsSaid) {
    std::mt19937_64 random(6);
    const Judgement judgement = judge(Relation::Equals, noisy(kGrey, 0, 0.3, 4, random), 1e-8);
    ASSERT_TRUE(judgement.holds);
    EXPECT_GT(judgement.half_width, 0.05);
    EXPECT_TRUE(verdict_text(judgement).starts_with("holds (to +-")) << verdict_text(judgement);
    EXPECT_EQ(verdict_text(judge(Relation::Equals, noisy(kGrey, 0, 1e-5, 8, random), 1e-8)), "holds");
}

TEST(HardCaseVerdict, BlackAnswersAreJudgedAsRadiance) {
    RegionSamples samples{{{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}};
    Judgement judgement = judge(Relation::SameAs, samples, 1e-6);
    EXPECT_TRUE(judgement.holds);
    EXPECT_FALSE(judgement.relative);
    for (Radiance& mean : samples.means) mean[1] = 1e-3;
    judgement = judge(Relation::SameAs, samples, 1e-6);
    EXPECT_FALSE(judgement.holds);
    EXPECT_DOUBLE_EQ(judgement.bias, 1e-3);
    // A black channel of a coloured answer is measured by the brightest.
    samples.answers = {{2, 0, 0}, {2, 0, 0}};
    samples.means = {{2, 0.5, 0}, {2, 0.5, 0}};
    judgement = judge(Relation::Equals, samples, 1e-6);
    EXPECT_TRUE(judgement.relative);
    EXPECT_EQ(judgement.channel, 1U);
    EXPECT_DOUBLE_EQ(judgement.bias, 0.25);
}

TEST(HardCaseVerdict, NaNBreaks) {
    RegionSamples samples{{kGrey, kGrey}, {kGrey, kGrey}};
    samples.means[0][2] = std::nan("");
    EXPECT_FALSE(judge(Relation::Equals, samples, 1e-6).holds);
    EXPECT_EQ(judge(Relation::Equals, samples, 1e-6).channel, 2U);
}

/// x of a pixel in red, y in green, 1 in blue.
LayerPixels ramp(ImageSize size) {
    LayerPixels layer{size, {}};
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x)
            for (const float value : {static_cast<float>(x), static_cast<float>(y), 1.0F}) layer.rgb.push_back(value);
    return layer;
}

TEST(HardCaseRegion, PixelsCountByTheirShare) {
    const LayerPixels layer = ramp({8, 4});
    EXPECT_EQ(region_mean(layer, {}), (Radiance{3.5, 1.5, 1}));
    EXPECT_EQ(region_mean(layer, {0.25, 0, 0.5, 0.5}), (Radiance{2.5, 0.5, 1}));  // columns 2, 3; rows 0, 1: the top
    // Columns 2 and half of 3: (2 + 3/2) / 1.5
    EXPECT_NEAR(region_mean(layer, {0.25, 0, 0.4375, 1})[0], 3.5 / 1.5, 1e-12);
    EXPECT_THROW(region_mean(layer, {0.5, 0, 0.5, 1}), Failure);
}

TEST(HardCaseRegion, TheWorstPixelIsThatOfTheMeanOverSeeds) {
    LayerPixels dark = ramp({8, 4}), bright = ramp({8, 4});
    bright.rgb[3 * (2 * 8 + 5) + 2] = 21;  // pixel (5, 2), blue
    MeanLayer mean;
    mean.add(dark);
    mean.add(bright);
    EXPECT_EQ(mean.pixel(5, 2), (Radiance{5, 2, 11}));
    const WorstPixel worst = worst_pixel(mean, {}, {3.5, 1.5, 1}, 2);
    EXPECT_EQ(worst.x, 5U);
    EXPECT_EQ(worst.y, 2U);
    EXPECT_DOUBLE_EQ(worst.deviation, 5);
    MeanLayer other;
    other.add(dark);
    EXPECT_DOUBLE_EQ(worst_pixel(mean, {}, other, 1, 1).deviation, 10);
    EXPECT_EQ(worst_pixel(mean, {0, 0, 0.5, 1}, other, 1, 1).deviation, 0);
    // Pixels that are cut by the region's edge are not judged alone.
    EXPECT_EQ(worst_pixel(mean, {0, 0, 5.5 / 8, 1}, other, 1, 1).deviation, 0);
}

TEST(HardCaseRegion, WhatNoRadianceMayBeIsCounted) {
    LayerPixels layer = ramp({2, 2});
    EXPECT_EQ(faults_of(layer).all(), 0U);
    layer.rgb[0] = NAN;
    layer.rgb[1] = -1e-30F;
    layer.rgb[2] = -INFINITY;
    layer.rgb[3] = INFINITY;
    const PixelFaults faults = faults_of(layer);
    EXPECT_EQ(faults.nan, 1U);
    EXPECT_EQ(faults.infinite, 2U);
    EXPECT_EQ(faults.negative, 2U);  // minus infinity too
    EXPECT_TRUE(std::isfinite(region_mean(layer, {})[0]));
    EXPECT_THROW(layer_from(std::string(11, 'x'), {1, 1}), Failure);
}

HardCase aligned(const ImageRegion& region, ImageSize size) {
    HardCase one;
    one.scene = "hard-case/one";
    one.size = size;
    one.checks.push_back({Relation::Equals, "direct", region});
    return one;
}

TEST(HardCaseSize, SmallImagesKeepWhatTheRegionsAre) {
    EXPECT_EQ(small_image(aligned({}, {64, 32})), (ImageSize{16, 8}));
    EXPECT_EQ(small_image(aligned({0.25, 0, 0.5, 1}, {64, 64})), (ImageSize{16, 16}));
    EXPECT_EQ(small_image(aligned({1.0 / 32, 0, 0.5, 1}, {64, 64})), (ImageSize{32, 32}));
    EXPECT_EQ(small_image(aligned({1.0 / 64, 0, 0.5, 1}, {64, 64})), (ImageSize{64, 64}));
    EXPECT_EQ(small_image(aligned({}, {16, 16})), (ImageSize{8, 8}));
    EXPECT_EQ(small_image(aligned({}, {9, 9})), (ImageSize{9, 9}));
}

nlohmann::json wire_case() {
    return {{"name", "hard-case/corner-90"},
            {"known_answer",
             {{"case", "corner, 90 and 10 degrees"},
              {"strains", "leaks"},
              {"text", "half the light"},
              {"checks",
               {{{"relation", "same_as"},
                 {"layer", "indirect"},
                 {"region", {0, 0.5, 1, 1}},
                 {"value", nullptr},
                 {"scene", "hard-case/other"},
                 {"scale", 1e6},
                 {"bounces", 1},
                 {"tolerance", 0.01}}}},
              {"passes", 64},
              {"width", 32},
              {"height", 16},
              {"not_applicable", {{"photon_splatting", "no media"}}}}}};
}

TEST(HardCaseScenes, AreReadAsTheProtocolSays) {
    const HardCase one = hard_case_from(wire_case());
    EXPECT_EQ(one.name(), "corner-90");
    EXPECT_EQ(one.row, "corner, 90 and 10 degrees");
    ASSERT_EQ(one.checks.size(), 1U);
    EXPECT_EQ(one.checks[0].relation, Relation::SameAs);
    EXPECT_EQ(one.checks[0].region, (ImageRegion{0, 0.5, 1, 1}));
    EXPECT_EQ(one.checks[0].scale, 1e6);
    EXPECT_EQ(one.checks[0].bounces, 1U);
    EXPECT_EQ(one.size, (ImageSize{32, 16}));
    EXPECT_EQ(one.not_applicable.at("photon_splatting"), "no media");

    nlohmann::json below = wire_case();
    below["known_answer"]["test"] = "unit_film";
    below["name"] = nullptr;
    EXPECT_EQ(hard_case_from(below).test, "unit_film");
    EXPECT_TRUE(hard_case_from(below).scene.empty());

    nlohmann::json wrong = wire_case();
    wrong["known_answer"]["checks"][0]["relation"] = "resembles";
    EXPECT_THROW(hard_case_from(wrong), Failure);
    wrong["known_answer"]["checks"][0]["relation"] = "equals";  // without a value
    EXPECT_THROW(hard_case_from(wrong), Failure);
}

TEST(HardCaseScenes, AreChosenByNameOrRow) {
    HardCase other = hard_case_from(wire_case());
    other.scene = "hard-case/furnace";
    other.row = "furnace sphere / box";
    const std::vector<HardCase> all = {hard_case_from(wire_case()), other};
    EXPECT_EQ(chosen_cases(all, {}).size(), 2U);
    EXPECT_EQ(chosen_cases(all, {"corner-90"}).at(0).name(), "corner-90");
    EXPECT_EQ(chosen_cases(all, {"hard-case/furnace"}).at(0).name(), "furnace");
    EXPECT_EQ(chosen_cases(all, {"10 Degrees"}).at(0).name(), "corner-90");
    EXPECT_THROW(chosen_cases(all, {"furnase"}), Failure);
}

}  // namespace
}  // namespace photond::cli::hard_cases_verdict_test

// welch_map() against Welch's test written down for a block, and what it says.

#include "renderer/error/welch_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "renderer/core/rng.h"
#include "renderer/error/student_t.h"

namespace photond::welch_map_test {
namespace {

/// Grey images, so that luminance is their value.
std::vector<float> grey(const std::vector<float>& values) {
    std::vector<float> image;
    for (const float value : values) image.insert(image.end(), 3, value);
    return image;
}

TEST(WelchMap, FollowsWelchsTest) {
    // 3 x 1 pixels in blocks of two: the second block is cut.
    const CrossMeter references({3, 1}, grey({1.1f, 0.9f, 2}), grey({0.9f, 1.0f, 2}));
    const std::vector<std::vector<float>> films{grey({1, 2, 2}), grey({2, 2, 3}), grey({1, 1, 2.5f})};
    const WelchMap map = welch_map(references, films, 2);
    ASSERT_EQ(map.size.width, 2u);
    ASSERT_EQ(map.size.height, 1u);
    EXPECT_EQ(map.seeds, 3u);
    EXPECT_EQ(map.tested, 2u);
    const double r = (1.0 + 0.95) / 2, mean = 1.5, image_mean = (1.0 + 0.95 + 2) / 3;
    const double scale = std::sqrt(r * r + 0.01 * image_mean * image_mean);
    const double of_films = (0.0 + 0.25 + 0.25) / 2 / 3;  // of means 1.5, 2 and 1
    const double squares[] = {0.1 * 0.1, 0.05 * 0.05};
    const double of_reference = (squares[0] + squares[1]) / 4;
    const double reference_degrees =
        3 * std::pow(squares[0] + squares[1], 2) / (squares[0] * squares[0] + squares[1] * squares[1]);
    const double degrees = std::pow(of_films + of_reference, 2) /
                           (of_films * of_films / 2 + of_reference * of_reference / reference_degrees);
    const WelchBlock& block = map.blocks[0];
    EXPECT_NEAR(block.difference, (mean - r) / scale, 1e-6);
    EXPECT_NEAR(block.standard_error, std::sqrt(of_films + of_reference) / scale, 1e-6);
    EXPECT_NEAR(block.degrees, degrees, 1e-4);
    // Nearly all of the noise is the films'.
    EXPECT_NEAR(block.p, student_t_tails((mean - r) / std::sqrt(of_films + of_reference), 2), 1e-2);
    // Of the cut one the reference has no noise.
    EXPECT_NEAR(map.blocks[1].degrees, 2, 1e-9);
    EXPECT_NEAR(map.blocks[1].p, student_t_tails(std::sqrt(3.0), 2), 1e-5);
}

TEST(WelchMap, RareChancesKeepTheirDigits) {
    // Beside references without noise t is Student's. Two films of 32 pixels differ in one, by less and less.
    const CrossMeter references({32, 1}, std::vector<float>(96, 0), std::vector<float>(96, 0));
    for (const float apart : {1e-2f, 1e-4f, 1e-6f, 1e-8f}) {
        std::vector<float> values(32, 0);
        values[0] = 1;
        std::vector<std::vector<float>> films(2, grey(values));
        values[1] = apart;
        films[1] = grey(values);
        const WelchMap map = welch_map(references, films);
        const WelchBlock& block = map.blocks[0];
        ASSERT_EQ(block.degrees, 1);
        const double chance = student_t_tails(block.difference / block.standard_error, 1);
        EXPECT_NEAR(block.p / chance, 1, 1e-5) << chance;  // 1e-6 of a difference is rounding
    }
}

TEST(WelchMap, SaysWhatWouldBeFoundByTwoSeedsInManyBlocks) {
    // Blocks of a pixel, all alike: each has to have a chance of 1 % over their number, that is 2 / (pi t).
    constexpr uint32_t kBlocks = 200'000;
    const std::vector<float> reference(3 * kBlocks, 1);
    const CrossMeter references({kBlocks, 1}, reference, reference);
    const std::vector<std::vector<float>> films{std::vector<float>(3 * kBlocks, 1 - 0x1p-10f),
                                                std::vector<float>(3 * kBlocks, 1 + 0x1p-10f)};
    const WelchMap map = welch_map(references, films, 1);
    const WelchBlock& block = map.blocks[0];
    const double t = 2 * kBlocks / (std::numbers::pi * WelchMap::kLevel);
    EXPECT_NEAR(map.detectable / block.standard_error / t, 1, 1e-4);
}

TEST(WelchMap, SaysHowManyBlocksDifferAndTheWorst) {
    // 8 x 1 blocks of four pixels whose noise cancels in each; one is 2 % too bright.
    RandomStream random(1, RandomDomain::Test, 0, 0);
    const CrossMeter references({32, 1}, std::vector<float>(96, 1), std::vector<float>(96, 1));
    std::vector<std::vector<float>> films;
    for (int i = 0; i < 12; ++i) {
        std::vector<float> values;
        for (int block = 0; block < 8; ++block)
            values.insert(values.end(), 4, (block == 5 ? 1.02f : 1.0f) + 0.002f * (random.next() - 0.5f));
        films.push_back(grey(values));
    }
    const WelchMap map = welch_map(references, films, 4);
    EXPECT_EQ(map.found, 1u);
    EXPECT_TRUE(map.blocks[5].found);
    EXPECT_EQ(map.text().substr(0, 82),
              "biased: 1 of 8 blocks differs from the reference at a level of 1 %, the worst by +");
    for (std::vector<float>& film : films)
        for (size_t value = 3 * 20; value < 3 * 24; ++value) film[value] -= 0.02f;
    const WelchMap uniform = welch_map(references, films, 4);
    EXPECT_EQ(uniform.found, 0u);
    const std::string text = uniform.text();
    EXPECT_EQ(text.find("no block of 8 differs from the reference at a level of 1 %; a bias of 0."), 0u) << text;
    EXPECT_FALSE(uniform.heavy_tailed);
}

TEST(WelchMap, RoundingIsNoDifference) {
    const std::vector<float> reference(3 * 64, 1);
    const CrossMeter references({64, 1}, reference, reference);
    const auto shifted = [](float by) { return std::vector<std::vector<float>>(3, std::vector<float>(3 * 64, by)); };
    EXPECT_EQ(welch_map(references, shifted(std::nextafter(1.0f, 2.0f))).found, 0u);
    const WelchMap map = welch_map(references, shifted(1.001f));
    EXPECT_EQ(map.found, 2u);
    EXPECT_EQ(map.blocks[0].p, 0);
    EXPECT_EQ(map.blocks[0].degrees, 0);
}

TEST(WelchMap, BlocksWithoutAFinitePixelAreNotTested) {
    std::vector<float> film(3 * 64, 1), black(3 * 64, 0);
    for (size_t value = 0; value < 3 * 32; ++value) film[value] = std::numeric_limits<float>::quiet_NaN();
    const std::vector<std::vector<float>> films(2, film);
    const WelchMap map = welch_map(CrossMeter({64, 1}, black, black), films);
    EXPECT_EQ(map.tested, 1u);
    EXPECT_FALSE(map.blocks[0].found);
    EXPECT_EQ(map.blocks[0].p, 1);
    EXPECT_TRUE(map.blocks[1].found);
    EXPECT_DOUBLE_EQ(map.blocks[1].difference, 1);  // absolute: the reference is black
    const std::vector<std::vector<float>> none(2, std::vector<float>(3 * 64, std::numeric_limits<float>::infinity()));
    EXPECT_EQ(welch_map(CrossMeter({64, 1}, black, black), none).text(), "no pixel is finite in all images");
}

}  // namespace
}  // namespace photond::welch_map_test

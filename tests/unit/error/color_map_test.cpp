#include "renderer/error/color_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/core/srgb.h"

namespace photond::color_map_test {
namespace {

/// CIELAB lightness of an 8-bit sRGB colour.
double lightness(const uint8_t* rgb) {
    const double y = 0.2126 * srgb_decode(rgb[0] / 255.0) + 0.7152 * srgb_decode(rgb[1] / 255.0) +
                     0.0722 * srgb_decode(rgb[2] / 255.0);
    return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : y * 24389 / 27;
}

std::vector<float> ramp() {
    std::vector<float> values(256);
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i) / 255;
    return values;
}

TEST(ColorMap, LightnessRisesEvenly) {
    const std::vector<uint8_t> rgb = color_mapped(ramp());
    ASSERT_EQ(rgb.size(), 3 * 256u);
    for (size_t i = 0; i < 256; ++i) {
        // From 2 to 98. A step of one code in green, the brightest, changes L* by up to 0.42; half of that each for
        // three rounded channels is less than this.
        EXPECT_NEAR(lightness(&rgb[3 * i]), 2 + 96.0 * static_cast<double>(i) / 255, 0.35) << i;
        // Two entries apart (0.75) it rises whatever the rounding.
        if (i >= 2) {
            EXPECT_GT(lightness(&rgb[3 * i]), lightness(&rgb[3 * (i - 2)])) << i;
        }
    }
}

TEST(ColorMap, GoesFromBlackOverPurpleRedAndYellowToWhite) {
    const std::vector<uint8_t> rgb = color_mapped(std::vector<float>{0, 0.25f, 0.5f, 0.8f, 1});
    const auto red = [&](size_t i) { return int{rgb[3 * i]}; };
    const auto green = [&](size_t i) { return int{rgb[3 * i + 1]}; };
    const auto blue = [&](size_t i) { return int{rgb[3 * i + 2]}; };
    EXPECT_LT(std::max({red(0), green(0), blue(0)}), 16);
    EXPECT_GT(std::min(red(1), blue(1)), 2 * green(1));  // purple
    EXPECT_GT(red(2), 2 * green(2));                     // red, leaning to pink
    EXPECT_GT(red(2), blue(2));
    EXPECT_GT(red(3), 240);  // orange
    EXPECT_GT(red(3), green(3));
    EXPECT_GT(green(3), blue(3) + 40);
    EXPECT_GT(std::min({red(4), green(4), blue(4)}), 200);  // near white
}

TEST(ColorMap, ClampsAndShowsNanAsMidGrey) {
    constexpr float kInf = std::numeric_limits<float>::infinity();
    const std::vector<uint8_t> rgb = color_mapped(std::vector<float>{-1, 0, kInf, 2, 1, std::nanf("")});
    const auto entry = [&](size_t i) {
        return std::vector<int>(rgb.begin() + 3 * long(i), rgb.begin() + 3 * long(i) + 3);
    };
    EXPECT_EQ(entry(0), entry(1));
    EXPECT_EQ(entry(2), entry(4));
    EXPECT_EQ(entry(3), entry(4));
    EXPECT_EQ(entry(5), (std::vector<int>{119, 119, 119}));
    EXPECT_TRUE(color_mapped({}).empty());
}

TEST(OverlapHeatMap, HasTheColoursOfTheThesis) {
    // [Hoet 2014, Figure 18]; half way between two of them is half of each, rounded away from 0.
    constexpr float kInf = std::numeric_limits<float>::infinity();
    const std::vector<float> splats{0, 100, 200, 300, 400, 500, 600, 50, -3, 601, kInf, std::nanf("")};
    const std::vector<uint8_t> expected{0,   0, 255, 0,   128, 128, 0,   255, 0,   128, 128, 0,
                                        255, 0, 0,   255, 128, 128, 255, 255, 255, 0,   64,  191,
                                        0,   0, 255, 255, 255, 255, 255, 255, 255, 119, 119, 119};
    EXPECT_EQ(overlap_heat_map(splats), expected);
    EXPECT_TRUE(overlap_heat_map({}).empty());
}

}  // namespace
}  // namespace photond::color_map_test

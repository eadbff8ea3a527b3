#include "renderer/film/tone_curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/core/srgb.h"

namespace photond::tone_curve_test {
namespace {

TEST(ToneCurve, ScalesByStopsAndClips) {
    const std::vector<float> grey{0.21404114f, 0.21404114f, 0.21404114f, 4.0f, 0.0f, -1.0f};
    const std::vector<uint8_t> as_is = tone_mapped(grey, 0, ToneCurve::Srgb);
    EXPECT_EQ(as_is, (std::vector<uint8_t>{128, 128, 128, 255, 0, 0}));
    const std::vector<uint8_t> darker = tone_mapped(grey, -2, ToneCurve::Srgb);
    EXPECT_EQ(darker[0], uint8_t(255 * srgb_encode(0.21404114f / 4) + 0.5f));
    EXPECT_EQ(darker[3], 255);  // 4 / 4 = 1
    EXPECT_EQ(tone_mapped(grey, -3, ToneCurve::Srgb)[3], uint8_t(255 * srgb_encode(0.5f) + 0.5f));
}

TEST(ToneCurve, ShowsNanAsMagentaAndInfinityAsWhite) {
    const std::vector<float> pixels{0.5f, std::nanf(""), 0.5f, kInfinity, kInfinity, kInfinity, -kInfinity, 0, 0};
    for (const ToneCurve curve : {ToneCurve::Srgb, ToneCurve::Filmic})
        EXPECT_EQ(tone_mapped(pixels, 0, curve), (std::vector<uint8_t>{255, 0, 255, 255, 255, 255, 0, 0, 0}));
}

TEST(ToneCurve, FilmicRisesAndKeepsDetailAboveOne) {
    uint8_t last = 0;
    for (float x = 0.01f; x < 64; x *= 1.5f) {
        const uint8_t code = tone_mapped(std::vector<float>(3, x), 0, ToneCurve::Filmic)[0];
        EXPECT_GE(code, last);
        last = code;
    }
    const auto code = [](float x) { return tone_mapped(std::vector<float>(3, x), 0, ToneCurve::Filmic)[0]; };
    EXPECT_LT(code(1.0f), code(2.0f));
    EXPECT_LT(code(2.0f), 255);
}

TEST(ToneCurve, AutoExposureBringsTheLogAverageToMiddleGrey) {
    std::vector<float> pixels;
    for (const float x : {0.01f, 0.09f}) pixels.insert(pixels.end(), 3, x);  // log-average 0.03
    pixels.insert(pixels.end(), 3, 0.0f);                                    // black does not count
    EXPECT_NEAR(auto_exposure_stops(pixels), std::log2(0.18f / 0.03f), 1e-4);
    EXPECT_EQ(auto_exposure_stops(std::vector<float>(9, 0.0f)), 0.0f);
}

TEST(ToneCurve, Names) {
    EXPECT_EQ(tone_curve_named("srgb"), ToneCurve::Srgb);
    EXPECT_EQ(tone_curve_named("filmic"), ToneCurve::Filmic);
    EXPECT_FALSE(tone_curve_named("aces"));
}

}  // namespace
}  // namespace photond::tone_curve_test

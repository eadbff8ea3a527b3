#include "renderer/core/srgb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "renderer/core/srgb_lanes.h"

namespace photond::srgb_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

double exact_encode(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }

TEST(Srgb, EncodesByTheStandard) {
    // IEC 61966-2-1 at its ends, its joint and middle grey (0.214 linear is code 127.5 of 255).
    EXPECT_EQ(srgb_encode(0), 0.0f);
    EXPECT_NEAR(srgb_encode(1), 1.0f, 1e-6);
    EXPECT_NEAR(srgb_encode(0.0031308f), 0.04045f, 1e-5);
    EXPECT_NEAR(srgb_encode(0.21404114f), 0.5f, 1e-5);
}

TEST(Srgb, DecodingUndoesEncoding) {
    EXPECT_EQ(srgb_decode(0), 0.0);
    EXPECT_DOUBLE_EQ(srgb_decode(1), 1.0);
    EXPECT_NEAR(srgb_decode(0.5), 0.21404114, 1e-8);
    // The standard's joint is rounded to 0.0031308 and 0.04045: the two curves miss each other by 4e-8 there.
    for (int i = 0; i <= 1000; ++i) EXPECT_NEAR(srgb_decode(exact_encode(i / 1000.0)), i / 1000.0, 4e-8);
}

TEST(SrgbLanes, IsWithinItsStatedErrorOfTheExactCurve) {
    // Every 97th float from 2^-20 to 1: 1.7 million values, over all exponents and the whole mantissa.
    double worst = 0;
    const uint32_t last = std::bit_cast<uint32_t>(1.0f);
    for (uint32_t bits = std::bit_cast<uint32_t>(0x1p-20f); bits < last; bits += 97 * uint32_t{kLanes}) {
        const FloatLanes x([&](auto lane) { return std::bit_cast<float>(std::min(bits + 97 * uint32_t(lane), last)); });
        const FloatLanes encoded = srgb_encode_clamped(x);
        for (size_t lane = 0; lane < kLanes; ++lane)
            worst = std::max(worst, std::fabs(double{encoded[lane]} - exact_encode(double{x[lane]})));
    }
    EXPECT_LT(worst, 2.5e-7);
    EXPECT_GT(worst, 1e-8);  // floats: were it less, nothing would have been compared
}

TEST(SrgbLanes, ClampsAndTakesNanAsBlack) {
    for (const float x : {0.0f, -0.0f, -1.0f, -kInfinity, kNan}) EXPECT_EQ(srgb_encode_clamped(x)[0], 0.0f) << x;
    for (const float x : {1.0f, 2.0f, 1e38f, kInfinity}) EXPECT_NEAR(srgb_encode_clamped(x)[0], 1.0f, 2.5e-7) << x;
    EXPECT_EQ(srgb_encode_clamped(1.0f)[0], srgb_encode_clamped(kInfinity)[0]);
    EXPECT_EQ(srgb_encode_clamped(1e-40f)[0], 12.92f * 1e-40f);
}

}  // namespace
}  // namespace photond::srgb_test

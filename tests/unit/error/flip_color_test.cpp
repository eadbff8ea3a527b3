#include "renderer/error/flip_color.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "renderer/core/lane_math.h"
#include "renderer/error/aces_tone_curve.h"
#include "tests/support/direct_flip.h"

namespace photond::flip_color_test {
namespace {

using test::direct_flip::Color;

RgbLanes lanes_of(const Color& c) {
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}
/// YCxCz with its published scales.
Color ycxcz(const Color& rgb) {
    const OpponentLanes o = opponent_from_rgb(lanes_of(rgb));
    return {116 * double{o.y[0]} - 16, 500 * double{o.cx[0]}, 200 * double{o.cz[0]}};
}
Color hunt_lab(const Color& rgb) {
    const HuntLabLanes lab = hunt_lab_from_rgb(lanes_of(rgb));
    return {lab.l[0], lab.a[0], lab.b[0]};
}
double largest_difference(const Color& p, const Color& q) {
    return std::max({std::fabs(p[0] - q[0]), std::fabs(p[1] - q[1]), std::fabs(p[2] - q[2])});
}

constexpr Color kBlack{0, 0, 0}, kWhite{1, 1, 1}, kRed{1, 0, 0}, kGreen{0, 1, 0}, kBlue{0, 0, 1};

TEST(FlipColor, OpponentSpaceOfKnownColours) {
    EXPECT_LT(largest_difference(ycxcz(kWhite), {100, 0, 0}), 1e-4);
    EXPECT_LT(largest_difference(ycxcz(kBlack), {-16, 0, 0}), 1e-6);
    // Red: X/Xn = 0.41239/0.95046, Y/Yn = 0.21264, Z/Zn = 0.01933/1.08906.
    EXPECT_LT(largest_difference(ycxcz(kRed), {8.6661, 500 * (0.43388 - 0.21264), 200 * (0.21264 - 0.01775)}), 0.01);
}

TEST(FlipColor, OpponentSpaceAndBack) {
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 200; ++i) {
        const Color rgb{uniform(generator), uniform(generator), uniform(generator)};
        const RgbLanes back = rgb_from_opponent(opponent_from_rgb(lanes_of(rgb)));
        EXPECT_LT(largest_difference(rgb, {back.r[0], back.g[0], back.b[0]}), 2e-6);
        EXPECT_LT(largest_difference(ycxcz(rgb), test::direct_flip::ycxcz_of(rgb)), 1e-3);
    }
}

TEST(FlipColor, LabOfWhiteAndPrimaries) {
    EXPECT_LT(largest_difference(hunt_lab(kWhite), {100, 0, 0}), 1e-4);
    EXPECT_LT(largest_difference(hunt_lab(kBlack), {0, 0, 0}), 1e-4);
    // CIELAB of the primaries as tabulated for sRGB, then Hunt: chroma times L / 100.
    const auto hunt = test::direct_flip::hunt;
    EXPECT_LT(largest_difference(hunt_lab(kRed), hunt({53.24, 80.09, 67.20})), 0.02);
    EXPECT_LT(largest_difference(hunt_lab(kGreen), hunt({87.73, -86.18, 83.18})), 0.02);
    EXPECT_LT(largest_difference(hunt_lab(kBlue), hunt({32.30, 79.19, -107.86})), 0.02);
}

TEST(FlipColor, LabIsThatOfTheDefinition) {
    std::mt19937 generator(2);
    std::uniform_real_distribution<double> exponent(-12, 0);
    double largest = 0;
    for (int i = 0; i < 2000; ++i) {  // half of them on the line near black
        const Color rgb{std::exp2(exponent(generator)), std::exp2(exponent(generator)), std::exp2(exponent(generator))};
        const Color exact = test::direct_flip::hunt(test::direct_flip::lab_of(rgb));
        largest = std::max(largest, largest_difference(hunt_lab(rgb), exact));
    }
    EXPECT_LT(largest, 1e-4);  // as the header states
}

TEST(FlipColor, GreenAndBlueAreTheLargestDistance) {
    // |87.73 - 32.30| + hypot of Hunt-adjusted chroma: (-75.61 - 25.58, 72.98 + 34.84).
    EXPECT_NEAR(largest_hyab(), 55.44 + std::hypot(101.19, 107.82), 0.05);
    std::vector<HuntLabLanes> colors;
    for (int i = 0; i < 125; ++i)
        colors.push_back(hunt_lab_from_rgb(lanes_of({i % 5 / 4.0, i / 5 % 5 / 4.0, i / 25 / 4.0})));
    for (const HuntLabLanes& p : colors)
        for (const HuntLabLanes& q : colors) EXPECT_LE(hyab(p, q)[0], largest_hyab());
}

TEST(FlipColor, DistanceIsCityBlockAndEuclidean) {
    const HuntLabLanes p{50.0f, 3.0f, -1.0f}, q{40.0f, 0.0f, 3.0f};
    EXPECT_FLOAT_EQ(hyab(p, q)[0], 15);  // 10 + hypot(3, 4)
    EXPECT_EQ(hyab(p, q)[0], hyab(q, p)[0]);
    EXPECT_EQ(hyab(p, p)[0], 0);
}

TEST(FlipColor, ErrorIsRedistributedAtItsKnots) {
    const auto error = [](double distance) { return double{color_error(static_cast<float>(distance))[0]}; };
    const double largest = largest_hyab();
    EXPECT_EQ(error(0), 0);
    const double knee = largest * std::pow(0.4, 1 / 0.7);
    EXPECT_NEAR(error(knee * 0.99999), 0.95, 2e-5);
    EXPECT_NEAR(error(knee * 1.00001), 0.95, 2e-5);
    EXPECT_NEAR(error(largest), 1, 1e-6);
    EXPECT_LE(error(largest * 1.01), 1);
    EXPECT_NEAR(error(knee * std::pow(0.5, 1 / 0.7)), 0.475, 2e-6);  // linear in distance^0.7
    EXPECT_NEAR(error(largest * std::pow(0.7, 1 / 0.7)), 0.975, 2e-6);
    for (double distance = 0.01; distance < 203; distance *= 1.1)
        EXPECT_NEAR(error(distance), test::direct_flip::color_error(distance), 2e-6);
}

TEST(AcesToneCurve, KnownValuesAndInverse) {
    const auto at = [](double x) { return double{AcesToneCurve::at(static_cast<float>(x))[0]}; };
    EXPECT_EQ(at(0), 0);
    EXPECT_NEAR(at(1), 0.9216 / 1.3688, 1e-6);
    EXPECT_EQ(at(13), 1);
    EXPECT_EQ(at(3e38), 1);
    for (double x = 1e-4; x < 12; x *= 1.3) {
        EXPECT_NEAR(at(x), test::direct_flip::aces(x), 1e-6);
        EXPECT_NEAR(AcesToneCurve::inverse(test::direct_flip::aces(x)), x, 1e-9 * (1 + x));
    }
    EXPECT_NEAR(AcesToneCurve::inverse(0.85), 2.1189, 1e-4);  // 0.16002 x^2 - 0.2829 x - 0.119 = 0
}

/// Largest error of a function of lanes over x from low to high in even ratios; `error(x, value)`.
template <class Function, class Error>
double largest_error(double low, double high, const Function& function, const Error& error) {
    double largest = 0;
    const double step = std::pow(high / low, 1e-5);
    for (double x = low; x <= high; x *= step) {
        const auto rounded = static_cast<float>(x);
        largest = std::max(largest, std::fabs(error(double{rounded}, double{function(FloatLanes(rounded))[0]})));
    }
    return largest;
}

TEST(LaneMath, ErrorsAreBelowTheStatedOnes) {
    const auto relative = [](double exact, double value) { return value / exact - 1; };
    EXPECT_LT(largest_error(1e-30, 1e30, cube_root, [&](double x, double v) { return relative(std::cbrt(x), v); }),
              3e-7);
    EXPECT_LT(
        largest_error(1e-30, 1e30, log2_lanes,
                      [](double x, double v) { return (v - std::log2(x)) / (2e-7 + 1e-7 * std::fabs(std::log2(x))); }),
        1);
    const auto exp2_of_both = [&](double x, double) {
        return std::max(std::fabs(relative(std::exp2(x), exp2_lanes(static_cast<float>(x))[0])),
                        std::fabs(relative(std::exp2(-x), exp2_lanes(static_cast<float>(-x))[0])));
    };
    EXPECT_LT(largest_error(1e-6, 125, exp2_lanes, exp2_of_both), 3e-7);
    for (const float p : {0.01f, 0.3f, 0.7f, 1.0f}) {
        const auto to_p = [p](const FloatLanes& x) { return power(x, p); };
        const double low = std::exp2(-8 / double{p});
        EXPECT_LT(largest_error(std::max(1e-35, low), 200, to_p,
                                [&](double x, double v) { return relative(std::pow(x, double{p}), v); }),
                  1e-6);
        EXPECT_EQ(power(0.0f, p)[0], 0);
    }
}

}  // namespace
}  // namespace photond::flip_color_test

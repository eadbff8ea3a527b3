// Flicker, lag and change against their definitions and against truths that are known.

#include "renderer/error/motion_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "renderer/core/rng.h"

namespace photond::motion_errors_test {
namespace {

TEST(MotionErrors, FollowTheirDefinitions) {
    const std::vector<float> u{1, 2, 3, 4, 5, 6}, v{1.25f, 2, 3, 4, 5, 6.5f}, a{2, 4, 6, 8, 10, 12};
    const std::vector<float> u_before{1, 1, 3, 3, 5, 5}, v_before{1, 1.5f, 3, 4, 5, 5}, a_before{1, 4, 5, 8, 9, 12};
    const CrossMeter now({2, 1}, u, v), before({2, 1}, u_before, v_before);
    ASSERT_EQ(now.denominators(), Denominators::Pixel);
    double mean = 0;
    for (size_t i = 0; i < 6; ++i) mean += (double{u[i]} + double{v[i]}) / 12;
    double flicker = 0, lag = 0, change = 0;
    for (size_t i = 0; i < 6; ++i) {
        const double du = double{u[i]} - double{u_before[i]}, dv = double{v[i]} - double{v_before[i]};
        const double da = double{a[i]} - double{a_before[i]}, x = double{a[i]} - double{u[i]},
                     y = double{a[i]} - double{v[i]};
        const double r = (double{u[i]} + double{v[i]}) / 2, d = r * r + 0.01 * mean * mean, dr = (du + dv) / 2;
        const double nu = (x - y) * (x - y) / (4 * d), squared = 2.0 / 3 * nu * nu * (4 * r * r / d - 1);
        flicker += ((da - du) * (da - dv) / d - 4 * nu * (da - dr) * r / d + squared) / 6;
        lag += ((x * dv + y * du) / (2 * d) + 2 * nu * (double{a[i]} - r - dr) * r / d - squared) / 6;
        change += (du * dv / d + 4 * nu * dr * r / d + squared) / 6;
    }
    const MotionErrors errors = motion_errors(now, before, a, a_before);
    EXPECT_NEAR(errors.flicker.value().value, flicker, 1e-7);
    EXPECT_NEAR(errors.lag.value().value, lag, 1e-7);
    EXPECT_NEAR(errors.change.value().value, change, 1e-7);
    EXPECT_EQ(errors.left_out, 0u);
}

TEST(MotionErrors, LeaveOutWhatIsNotFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> one(6, 1), two(6, 2);
    std::vector<float> broken = one, broken_before = one;
    broken[1] = nan, broken_before[5] = nan;
    const CrossMeter now({2, 1}, two, two), before({2, 1}, one, one);
    const MotionErrors errors = motion_errors(now, before, broken, broken_before);
    EXPECT_EQ(errors.left_out, 2u);
    EXPECT_NEAR(errors.flicker.value().value, 1 / (4 + 0.04), 1e-7);  // the image stays where the truth doubles
    const CrossMeter black({2, 1}, std::vector<float>(6, 0), std::vector<float>(6, 0));
    EXPECT_FALSE(motion_errors(black, black, one, one).flicker);
}

/// A striped pattern that moves a pixel a frame; films are of it with noise of their own each.
class Moving {
public:
    static constexpr Size2 kSize{64, 32};

    static std::vector<float> truth(double frame) {
        std::vector<float> image(3 * kSize.pixels());
        for (size_t i = 0; i < image.size(); ++i)
            image[i] = static_cast<float>(1 + 0.5 * std::sin(0.4 * (static_cast<double>(i / 3 % kSize.width) - frame)));
        return image;
    }
    std::vector<float> film(double frame, double noise) {
        std::vector<float> image = truth(frame);
        for (float& value : image) value *= static_cast<float>(1 + noise * normal());
        return image;
    }

private:
    double normal() {
        const double radius = std::sqrt(-2 * std::log(1 - double{random_.next()}));
        return radius * std::cos(2 * 3.14159265358979 * double{random_.next()});
    }
    RandomStream random_{1, RandomDomain::Test, 7, 0};
};

/// What a figure is off by over trials, and the variance that it states.
struct Calibration {
    double truth;
    double sum = 0, squares = 0, stated = 0;
    int count = 0;

    void add(const std::optional<CrossError>& found) {
        const double off = found.value().value - truth;
        sum += off, squares += off * off, stated += found->standard_error * found->standard_error, ++count;
    }
    void expect_sound(const char* figure, double noise) const {
        const double n = count, mean = sum / n, variance = squares / n - mean * mean;
        // At a false-alarm rate of 1e-7, and what D's own noise leaves of the figure: 3 nu (cross_meter.h).
        const double left = 3 * (noise * noise / 2) * std::fabs(truth);
        EXPECT_NEAR(mean, 0, 5.3 * std::sqrt(variance / n) + left)
            << figure << " where references have noise " << noise;
        // A sample's variance of nearly normal values scatters by sqrt(2 / n) of itself.
        EXPECT_NEAR(stated / n / variance, 1, 5.3 * std::sqrt(2 / n)) << figure << ", noise " << noise;
    }
};

/// Two films of a moving truth against references whose noise is `noise`: for the truth of each figure, the same
/// without noise in the references.
void expect_calibrated(double noise, double image_noise, double late) {
    Moving moving;
    const std::vector<float> truth = Moving::truth(1), truth_before = Moving::truth(0);
    const std::vector<float> a = moving.film(1 - late, image_noise), a_before = moving.film(-late, image_noise);
    double mean = 0;
    for (const float value : truth) mean += double{value} / static_cast<double>(truth.size());
    Calibration flicker{0}, lag{0}, change{0};
    for (size_t i = 0; i < truth.size(); ++i) {
        const double divisor =
            static_cast<double>(truth.size()) * (double{truth[i]} * double{truth[i]} + 0.01 * mean * mean);
        const double motion = double{truth[i]} - double{truth_before[i]};
        const double excess = double{a[i]} - double{a_before[i]} - motion;
        flicker.truth += excess * excess / divisor, change.truth += motion * motion / divisor;
        lag.truth += (double{a[i]} - double{truth[i]}) * motion / divisor;
    }
    for (int trial = 0; trial < 400; ++trial) {
        const CrossMeter now(Moving::kSize, moving.film(1, noise), moving.film(1, noise));
        const CrossMeter before(Moving::kSize, moving.film(0, noise), moving.film(0, noise));
        ASSERT_EQ(now.denominators(), Denominators::Pixel) << "or the truth has other denominators";
        const MotionErrors found = motion_errors(now, before, a, a_before);
        flicker.add(found.flicker), lag.add(found.lag), change.add(found.change);
    }
    flicker.expect_sound("flicker", noise), lag.expect_sound("lag", noise), change.expect_sound("change", noise);
}

TEST(MotionErrors, AreRightInTheMeanWhateverTheReferencesNoise) {
    expect_calibrated(0.01, 0.1, 0);
    expect_calibrated(0.04, 0.1, 0);
    expect_calibrated(0.04, 0, 0);
    expect_calibrated(0.04, 0.02, 1);
}

TEST(MotionErrors, FreshNoiseOfAStillSceneFlickersByTwiceItsVariance) {
    Moving moving;
    const CrossMeter still(Moving::kSize, Moving::truth(0), Moving::truth(0));
    const std::vector<float> a = moving.film(0, 0.05), b = moving.film(0, 0.05);
    const MotionErrors errors = motion_errors(still, still, a, b);
    double variances = 0;
    for (const auto* film : {&a, &b}) variances += still.measure(*film).relative_mse.value().value;
    // The products of two independent noises, each of so much variance: their mean scatters by less than 1 / sqrt(n).
    const double n = static_cast<double>(a.size());
    EXPECT_NEAR(errors.flicker.value().value, variances, 5.3 * variances / std::sqrt(n));
    EXPECT_EQ(errors.change.value().value, 0);
    EXPECT_EQ(motion_errors(still, still, a, a).flicker.value().value, 0) << "noise that stands still does not flicker";
}

TEST(MotionErrors, WhatShowsTheFrameBeforeIsOneFrameLate) {
    const CrossMeter now(Moving::kSize, Moving::truth(1), Moving::truth(1));
    const CrossMeter before(Moving::kSize, Moving::truth(0), Moving::truth(0));
    const MotionErrors late = motion_errors(now, before, Moving::truth(0), Moving::truth(-1));
    EXPECT_NEAR(MotionErrors::frames_late(*late.lag, *late.change).value(), 1, 1e-6);
    const MotionErrors right = motion_errors(now, before, Moving::truth(1), Moving::truth(0));
    EXPECT_NEAR(MotionErrors::frames_late(*right.lag, *right.change).value(), 0, 1e-9);
    EXPECT_NEAR(right.flicker.value().value, 0, 1e-12);
    const MotionErrors still = motion_errors(now, now, Moving::truth(1), Moving::truth(0));
    EXPECT_FALSE(MotionErrors::frames_late(*still.lag, *still.change));
}

}  // namespace
}  // namespace photond::motion_errors_test

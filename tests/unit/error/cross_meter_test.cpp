// CrossMeter against its definition, written down value by value.

#include "renderer/error/cross_meter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/rng.h"

namespace photond::cross_meter_test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(CrossMeter, FollowsItsDefinition) {
    const std::vector<float> u{1, 2, 3, 4, 5, 6}, v{1.25f, 2, 3, 4, 5, 6.5f}, a{2, 4, 6, 8, 10, 12};
    const CrossErrors errors = CrossMeter({2, 1}, u, v).measure(a);
    double mean = 0;
    for (size_t i = 0; i < 6; ++i) mean += (double{u[i]} + double{v[i]}) / 12;
    double products = 0, relative = 0, shared = 0, terms = 0, relative_terms = 0;
    for (size_t pixel = 0; pixel < 2; ++pixel) {
        double q = 0, relative_q = 0;
        for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
            const double x = double{a[i]} - double{u[i]}, y = double{a[i]} - double{v[i]};
            const double r = (double{u[i]} + double{v[i]}) / 2, d = r * r + 0.01 * mean * mean;
            const double nu = (x - y) * (x - y) / (4 * d);
            shared += (4 * nu * (double{a[i]} - r) * r / d - 2.0 / 3 * nu * nu * (4 * r * r / d - 1)) / 6;
            products += x * y / 6, relative += x * y / d / 6;
            q += (x * x - y * y) / 2, relative_q += (x * x - y * y) / (2 * d);
        }
        terms += q * q, relative_terms += relative_q * relative_q;
    }
    EXPECT_NEAR(errors.mse.value().value, products, 1e-12);
    EXPECT_NEAR(errors.mse.value().standard_error, std::sqrt(terms) / 6, 1e-12);  // what x y scatters by is more
    EXPECT_NEAR(errors.relative_mse.value().value, relative - shared, 1e-7);
    EXPECT_GT(shared, 1e-4) << "or the image shows nothing of it";
    EXPECT_NEAR(errors.relative_mse.value().standard_error, std::sqrt(relative_terms) / 6, 1e-7);
    EXPECT_EQ(errors.denominators, Denominators::Pixel);
    EXPECT_EQ(errors.left_out, 0u);
    const Interval interval = errors.mse->interval();
    EXPECT_NEAR((interval.greatest - interval.least) / errors.mse->standard_error, 2 * 1.6448536, 1e-6);
}

TEST(CrossMeter, LeavesOutWhatIsNotFinite) {
    const std::vector<float> u{1, 1, 1, kNaN, 1, 1}, v{1, kInfinity, 1, 1, 1, 1}, a{3, 1, 1, 1, 1, kInfinity};
    const CrossErrors errors = CrossMeter({2, 1}, u, v).measure(a);
    EXPECT_EQ(errors.left_out, 3u);
    EXPECT_DOUBLE_EQ(errors.mse.value().value, 4.0 / 3);
    EXPECT_FALSE(CrossMeter({1, 1}, {kNaN, kNaN, kNaN}, {1, 1, 1}).measure(std::vector<float>(3, 1)).mse);
}

TEST(CrossMeter, ARootHasAValueWhereItsSquareIsNotNegative) {
    const std::vector<float> a(6, 1);
    // Products -4 and 1 of two pixels.
    const CrossErrors below = CrossMeter({2, 1}, {3, 3, 3, 0, 0, 0}, {-1, -1, -1, 0, 0, 0}).measure(a);
    EXPECT_DOUBLE_EQ(figure_of(below, Metric::Mse).value().value.value(), -1.5);
    const CrossFigure root = figure_of(below, Metric::Rmse).value();
    EXPECT_FALSE(root.value);
    EXPECT_EQ(root.interval.least, 0);
    const CrossErrors above = CrossMeter({2, 1}, {3, 3, 3, 0, 0, 0}, {3, 3, 3, -1, -1, -1}).measure(a);
    EXPECT_DOUBLE_EQ(figure_of(above, Metric::Rmse).value().value.value(), std::sqrt(3.0));
    EXPECT_FALSE(figure_of(CrossErrors{}, Metric::Rmse));
    EXPECT_FALSE(is_quadratic(Metric::Mae));
}

/// Blocks of lanes and single values add up the same, whatever the image has beside: a row of its own for the sum of
/// each value alone, a width that leaves a rest, fireflies that no float's fourth power holds, and NaN.
TEST(CrossMeter, AWholeImageIsTheSumOfItsPixels) {
    constexpr Size2 kSize{37, 29};
    std::vector<float> u(3 * kSize.pixels()), v(u.size()), a(u.size());
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (size_t i = 0; i < u.size(); ++i) u[i] = 3 * random.next(), v[i] = 3 * random.next(), a[i] = 1 + random.next();
    const auto expect_sums = [&](double known_to) {
        double products = 0, squared_terms = 0, squared_products = 0;
        size_t count = 0;
        for (size_t pixel = 0; pixel < u.size(); pixel += 3) {
            double term = 0, product = 0;
            for (size_t i = pixel; i < pixel + 3; ++i) {
                const double x = double{a[i]} - double{u[i]}, y = double{a[i]} - double{v[i]};
                if (!std::isfinite(x) || !std::isfinite(y)) continue;
                product += x * y, term += (x * x - y * y) / 2, ++count;
            }
            products += product;
            squared_terms += term * term, squared_products += product * product;
        }
        const CrossErrors errors = CrossMeter(kSize, u, v).measure(a);
        const auto n = static_cast<double>(count);
        EXPECT_EQ(errors.left_out, u.size() - count);
        const double scatter = squared_products - products * products / static_cast<double>(kSize.pixels());
        const double mean = products / n, variance = std::min(squared_terms, scatter) / (n * n);
        const double standard_error = std::sqrt(squared_terms) / n;
        // Floats keep R and half of U - V: beside a firefly of one of them the other is known to 1e-7 of that.
        EXPECT_NEAR(errors.mse.value().value, mean, 1e-5 * std::fabs(mean) + 1e-6 * standard_error);
        // Of a difference of sums, to so much of these.
        EXPECT_NEAR(std::pow(errors.mse.value().standard_error, 2), variance,
                    1e-5 * variance + known_to * squared_products / (n * n));
        EXPECT_TRUE(std::isfinite(errors.relative_mse.value().value));
        EXPECT_TRUE(std::isfinite(errors.relative_mse.value().standard_error));
    };
    expect_sums(1e-6);
    a[100] = 3e8f, u[1000] = 1e6f, a[1001] = 2e5f;
    a[2000] = std::numeric_limits<float>::quiet_NaN();
    expect_sums(1e-6);
    a.assign(a.size(), 1e9f);
    for (float& value : u) value *= 1e9f;
    expect_sums(0.05);  // beside a value of u that is a million times the others, v is known to 3 %
}

TEST(CrossMeter, HasNoRelativeErrorAgainstBlack) {
    const CrossErrors errors = CrossMeter({1, 1}, {0, 0, 0}, {0, 0, 0}).measure(std::vector<float>{1, 2, 3});
    EXPECT_DOUBLE_EQ(errors.mse.value().value, 14.0 / 3);
    EXPECT_FALSE(errors.relative_mse);
}

TEST(CrossMeter, DividesByNeighboursWhereAPixelsNoiseWouldCount) {
    // 7 x 1 pixels of channels that are alike; the middle one's noise is half of it.
    std::vector<float> u(21, 2), v(21, 2), a(21, 2);
    for (size_t k = 9; k < 12; ++k) u[k] = 3, v[k] = 1;
    const CrossErrors errors = CrossMeter({7, 1}, u, v).measure(a);
    EXPECT_EQ(errors.denominators, Denominators::Neighbours);
    // Its own product is -1, over its neighbours' 2^2 + 0.01 * 2^2.
    EXPECT_NEAR(errors.relative_mse.value().value, -1 / 4.04 / 7, 1e-8);
    // Whatever the image is.
    EXPECT_EQ(CrossMeter({7, 1}, u, v).measure(std::vector<float>(21, 9)).denominators, Denominators::Neighbours);

    // Without noise the image's distance is all there is, at edges too.
    u = v = {1, 1, 1, 10, 10, 10};
    EXPECT_EQ(CrossMeter({2, 1}, u, v).measure(std::vector<float>(6, 5)).denominators, Denominators::Pixel);
}

}  // namespace
}  // namespace photond::cross_meter_test

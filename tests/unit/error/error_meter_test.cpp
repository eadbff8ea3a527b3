// Every measure against values worked by hand and against loops in long double that follow the definitions word by
// word.

#include "renderer/error/error_meter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

#include "renderer/core/rgb.h"
#include "renderer/core/rng.h"
#include "tests/support/threads.h"

namespace photond::error_meter_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kLargest = std::numeric_limits<float>::max();

using Image = std::vector<float>;

Image constant(Size2 size, float value) { return Image(3 * size.pixels(), value); }

/// A reference over three magnitudes with black parts, and an image of it with noise and a bias.
struct Pair {
    Size2 size;
    Image reference, image;

    Pair(Size2 the_size, uint64_t seed, float scale = 1) : size(the_size) {
        RandomStream random(seed, RandomDomain::Test, 0, 0);
        for (size_t i = 0; i < 3 * size.pixels(); ++i) {
            const float r = random.next() < 0.1f ? 0.0f : std::exp(7 * random.next() - 5);
            const float x = random.next() < 0.1f ? r : r * (0.5f + 1.2f * random.next()) + 0.1f * random.next() - 0.04f;
            reference.push_back(scale * r), image.push_back(scale * x);
        }
    }
    /// Some values are replaced, about one in `every`.
    Pair& with_specials(uint64_t seed, const std::vector<float>& specials, float every) {
        RandomStream random(seed, RandomDomain::Test, 1, 0);
        for (Image* values : {&reference, &image})
            for (float& value : *values)
                if (random.next() * every < 1) value = specials[random.next_bits() % specials.size()];
        return *this;
    }
};

using Real = long double;

Real display(float x) {
    const Real c = std::clamp<Real>(x, 0, 1);
    return 255 * (c <= Real(0.0031308) ? Real(12.92) * c : Real(1.055) * std::pow(c, 1 / Real(2.4)) - Real(0.055));
}

/// conventions.md, "Error", written down once more.
struct Expected {
    Real mean = 0, relative_mse = 0, rmse = 0, mae = 0, smape = 0, rmse_8bit = 0, bias[3]{}, relative_bias[3]{};
    Real exposure = 0, relative_exposure = 0, fitted_rmse = 0, fitted_relative_mse = 0;
    uint64_t left_out = 0;

    explicit Expected(const Pair& pair) {
        Real count = 0, channel_mean[3]{}, channel_count[3]{};
        for (size_t i = 0; i < pair.reference.size(); ++i) {
            if (!std::isfinite(pair.reference[i])) continue;
            mean += pair.reference[i], ++count;
            channel_mean[i % 3] += pair.reference[i], ++channel_count[i % 3];
        }
        mean /= count;
        for (int k = 0; k < 3; ++k) channel_mean[k] /= channel_count[k], channel_count[k] = 0;
        Real display_squares[3]{};
        count = 0;
        for (size_t i = 0; i < pair.reference.size(); ++i) {
            const Real r = pair.reference[i], x = pair.image[i];
            if (!std::isfinite(r) || !std::isfinite(x)) {
                ++left_out;
                continue;
            }
            ++count, ++channel_count[i % 3];
            relative_mse += (x - r) * (x - r) / (r * r + Real(0.01) * mean * mean);
            rmse += (x - r) * (x - r);
            mae += std::abs(x - r);
            smape += 2 * std::abs(x - r) / (std::abs(x) + std::abs(r) + Real(0.1) * std::abs(mean));
            bias[i % 3] += x - r;
            display_squares[i % 3] += std::pow(display(pair.image[i]) - display(pair.reference[i]), Real(2));
        }
        relative_mse /= count, rmse = std::sqrt(rmse / count), mae /= count, smape /= count;
        fit(pair, count);
        for (int k = 0; k < 3; ++k) {
            bias[k] /= channel_count[k];
            relative_bias[k] = bias[k] / channel_mean[k];
            rmse_8bit += std::sqrt(display_squares[k] / channel_count[k]);
        }
    }

private:
    /// Each exposure from its normal equation, then the measure itself of the image times that: nothing cancels.
    void fit(const Pair& pair, Real count) {
        const auto each = [&](const auto& visit) {
            for (size_t i = 0; i < pair.reference.size(); ++i)
                if (std::isfinite(pair.reference[i]) && std::isfinite(pair.image[i]))
                    visit(Real(pair.image[i]), Real(pair.reference[i]),
                          1 / (Real(pair.reference[i]) * Real(pair.reference[i]) + Real(0.01) * mean * mean));
        };
        Real xr = 0, xx = 0, relative_xr = 0, relative_xx = 0;
        each([&](Real x, Real r, Real weight) {
            xr += x * r, xx += x * x, relative_xr += weight * x * r, relative_xx += weight * x * x;
        });
        exposure = xr / xx, relative_exposure = relative_xr / relative_xx;
        each([&](Real x, Real r, Real weight) {
            fitted_rmse += (exposure * x - r) * (exposure * x - r);
            fitted_relative_mse += weight * (relative_exposure * x - r) * (relative_exposure * x - r);
        });
        fitted_rmse = std::sqrt(fitted_rmse / count), fitted_relative_mse /= count;
    }
};

/// Relative error: the sweep's own arithmetic is that of floats, rounded once or twice a value.
void expect_close(const std::optional<double>& value, Real expected, const char* what) {
    ASSERT_TRUE(value) << what;
    EXPECT_NEAR(*value / double(expected), 1, 1e-6) << what;
}

void expect_same(const Pair& pair) {
    const Expected expected(pair);
    const ErrorMeter meter(pair.size, pair.reference);
    const PointwiseErrors errors = meter.pointwise(pair.image);
    expect_close(meter.reference_mean(), expected.mean, "mean");
    expect_close(errors[Metric::RelativeMse], expected.relative_mse, "relative_mse");
    expect_close(errors[Metric::Rmse], expected.rmse, "rmse");
    expect_close(errors[Metric::Mae], expected.mae, "mae");
    expect_close(errors[Metric::Smape], expected.smape, "smape");
    expect_close(errors[Metric::FittedRmse], expected.fitted_rmse, "fitted_rmse");
    expect_close(errors[Metric::FittedRelativeMse], expected.fitted_relative_mse, "fitted_relative_mse");
    expect_close(errors.least_squares_exposure, expected.exposure, "least_squares_exposure");
    expect_close(errors.relative_least_squares_exposure, expected.relative_exposure, "relative exposure");
    ASSERT_TRUE(errors[Metric::Rmse8bit]);
    EXPECT_NEAR(*errors[Metric::Rmse8bit], double(expected.rmse_8bit),
                3e-4);  // three times the stated error of the sRGB curve
    for (size_t k = 0; k < 3; ++k) {
        ASSERT_TRUE(errors.channels(Metric::Bias)[k] && errors.channels(Metric::RelativeBias)[k]);
        // Differences cancel: their sum is as exact as the sum of their magnitudes.
        EXPECT_NEAR(*errors.channels(Metric::Bias)[k], double(expected.bias[k]), 1e-6 * double(expected.mae));
        EXPECT_NEAR(*errors.channels(Metric::RelativeBias)[k] / double(expected.relative_bias[k]),
                    *errors.channels(Metric::Bias)[k] / double(expected.bias[k]), 1e-9);
    }
    EXPECT_EQ(errors.left_out, expected.left_out);
}

TEST(ErrorMeter, FollowsTheDefinitionsOnRandomImages) {
    uint64_t seed = 0;
    for (const Size2 size : {Size2{2, 2}, {5, 1}, {1, 7}, {8, 1}, {37, 23}, {64, 64}, {97, 131}}) {
        SCOPED_TRACE(::testing::Message() << size.width << " x " << size.height);
        expect_same(Pair(size, ++seed));
    }
}

TEST(ErrorMeter, IsAsExactAtAnyScale) {
    for (const float scale : {1e-35f, 1e-20f, 1e-6f, 1e10f, 1e25f, 1e36f}) {
        SCOPED_TRACE(scale);
        expect_same(Pair({45, 33}, 11, scale));
    }
    // One pixel beyond all others: their squares differ by more than a float holds.
    expect_same(Pair({45, 33}, 12).with_specials(5, {1e12f, 1e20f, kLargest, -kLargest}, 500));
}

TEST(ErrorMeter, LeavesOutAndCountsWhatIsNotFinite) {
    expect_same(Pair({64, 65}, 21).with_specials(1, {kNan, kInfinity, -kInfinity}, 50));
    expect_same(Pair({101, 47}, 22).with_specials(2, {kNan, kInfinity, -kInfinity, kLargest, -3.0f}, 4));
    expect_same(Pair({640, 11}, 23).with_specials(3, {kNan, kInfinity}, 5000));

    const Size2 size{3, 1};
    const ErrorMeter meter(size, {1, 2, 3, 1, kNan, 3, 1, 2, kInfinity});
    const PointwiseErrors errors = meter.pointwise(Image{2, 2, kInfinity, kNan, 2, kNan, 2, kInfinity, -kInfinity});
    EXPECT_EQ(errors.left_out, 6u);  // all but 1 -> 2, 2 -> 2 and 1 -> 2
    EXPECT_DOUBLE_EQ(*errors[Metric::Mae], 2 / 3.0);
    EXPECT_DOUBLE_EQ(*errors.channels(Metric::Bias)[0], 1);
    EXPECT_DOUBLE_EQ(*errors.channels(Metric::Bias)[1], 0);
    EXPECT_FALSE(errors.channels(Metric::Bias)[2]);  // nothing is left
    EXPECT_FALSE(errors.channels(Metric::RelativeBias)[2]);
    EXPECT_FALSE(errors[Metric::Rmse8bit]);  // three channels added: one is missing
    EXPECT_TRUE(errors[Metric::RelativeMse]);

    std::string why;
    EXPECT_EQ(meter.measure(Metric::Mae, constant(size, 1)).size(), 1u);
    EXPECT_TRUE(meter.measure(Metric::Rmse8bit, Image{2, 2, kNan, 2, 2, kNan, 2, 2, 2}, &why).empty());
    EXPECT_EQ(why, "no finite values in channel B");
    const PointwiseErrors nothing = meter.pointwise(constant(size, kNan));
    EXPECT_EQ(nothing.left_out, 9u);
    EXPECT_FALSE(nothing[Metric::Rmse] || nothing[Metric::Mae] || nothing[Metric::RelativeMse] ||
                 nothing[Metric::Smape] || nothing[Metric::Rmse8bit]);
    EXPECT_FALSE(meter.percentiles(constant(size, kNan)));
}

TEST(ErrorMeter, MatchesValuesWorkedByHand) {
    // m = 2: 0.01 m^2 = 0.04, 0.1 m = 0.2. Differences 1, 0, 0 | 0, 0, -2.
    const ErrorMeter meter({2, 1}, {1, 1, 1, 3, 3, 3});
    const PointwiseErrors errors = meter.pointwise(Image{2, 1, 1, 3, 3, 1});
    EXPECT_DOUBLE_EQ(meter.reference_mean(), 2);
    EXPECT_NEAR(*errors[Metric::Mse], 5.0 / 6, 1e-7);
    EXPECT_NEAR(*errors[Metric::Rmse], std::sqrt(5.0 / 6), 1e-7);
    EXPECT_NEAR(*errors[Metric::Mae], 0.5, 1e-7);
    EXPECT_NEAR(*errors[Metric::RelativeMse], (1 / 1.04 + 4 / 9.04) / 6, 1e-7);
    EXPECT_NEAR(*errors[Metric::Smape], (2 * 1 / (2 + 1 + 0.2) + 2 * 2 / (1 + 3 + 0.2)) / 6, 1e-7);
    EXPECT_EQ(*errors[Metric::Rmse8bit], 0);  // a display shows 1, 2 and 3 alike
    // x.x = 4 + 1 + 1 + 9 + 9 + 1 = 25, x.r = 2 + 1 + 1 + 9 + 9 + 3 = 25, r.r = 30: s = 1, which leaves 5.
    EXPECT_DOUBLE_EQ(*errors.least_squares_exposure, 1);
    EXPECT_NEAR(*errors[Metric::FittedRmse], std::sqrt(5.0 / 6), 1e-7);
    // By 1.04 and 9.04: x.x = 6 / 1.04 + 19 / 9.04, x.r = 4 / 1.04 + 21 / 9.04, r.r = 3 / 1.04 + 27 / 9.04.
    const double xx = 6 / 1.04 + 19 / 9.04, xr = 4 / 1.04 + 21 / 9.04, rr = 3 / 1.04 + 27 / 9.04;
    EXPECT_NEAR(*errors.relative_least_squares_exposure, xr / xx, 1e-7);
    EXPECT_NEAR(*errors[Metric::FittedRelativeMse], (rr - xr * xr / xx) / 6, 1e-7);
    const double bias[] = {0.5, 0, -1};
    for (size_t k = 0; k < 3; ++k) {
        EXPECT_DOUBLE_EQ(*errors.channels(Metric::Bias)[k], bias[k]);
        EXPECT_DOUBLE_EQ(*errors.channels(Metric::RelativeBias)[k], bias[k] / 2);
    }
    EXPECT_EQ(errors.left_out, 0u);
}

TEST(ErrorMeter, ExposureIsTakenOutWholly) {
    const Pair pair({211, 67}, 81);
    const ErrorMeter meter(pair.size, pair.reference);
    const double squares = std::pow(*meter.pointwise(constant(pair.size, 0))[Metric::Rmse], 2);  // mean of r^2
    for (const float factor : {1e-6f, 0.02f, 0.9f, 1.1f, 64.0f, 3e5f}) {
        SCOPED_TRACE(factor);
        Image image = pair.reference;
        for (float& value : image) value *= factor;
        const PointwiseErrors errors = meter.pointwise(image);
        EXPECT_NEAR(*errors.least_squares_exposure * double(factor), 1, 1e-6);
        EXPECT_NEAR(*errors.relative_least_squares_exposure * double(factor), 1, 1e-6);
        EXPECT_LE(std::pow(*errors[Metric::FittedRmse], 2), 1e-6 * squares);
        EXPECT_LE(*errors[Metric::FittedRelativeMse], 1e-6);
    }
    const PointwiseErrors black = meter.pointwise(constant(pair.size, 0));
    EXPECT_FALSE(black.least_squares_exposure || black.relative_least_squares_exposure);
    EXPECT_EQ(*black[Metric::FittedRmse], *black[Metric::Rmse]);  // no factor helps
    EXPECT_EQ(*black[Metric::FittedRelativeMse], *black[Metric::RelativeMse]);
}

TEST(ErrorMeter, EightBitErrorIsOfTheDisplay) {
    // R: 0 against 0.21404114 (half of the display's range, 127.5), 1 against 5 (255): root mean square 127.5 / sqrt 2.
    // G: 0 against 0, 1 against 0: 255 / sqrt 2. B: 0 against -1 (0), and a value left out: 0.
    const ErrorMeter meter({2, 1}, {0, 0, 0, 1, 1, 1});
    const PointwiseErrors errors = meter.pointwise(Image{0.21404114f, 0, -1, 5, 0, kInfinity});
    EXPECT_NEAR(*errors[Metric::Rmse8bit], 382.5 / std::sqrt(2), 1e-4);
}

TEST(ErrorMeter, AnImageHasNoErrorAgainstItself) {
    const Pair pair({67, 71}, 31);
    const ErrorMeter meter(pair.size, pair.reference);
    for (const MetricInfo& info : kMetrics) {
        if (!info.needs_reference) continue;
        const std::vector<double> values = meter.measure(info.metric, pair.reference);
        EXPECT_EQ(values, std::vector<double>(info.values, 0.0)) << info.name;
    }
}

TEST(ErrorMeter, SaysWhyAReferenceOfMeanZeroHasNoRelativeError) {
    const Size2 size{4, 3};
    const ErrorMeter meter(size, constant(size, 0));
    const Image image = constant(size, 2e-25f);
    const PointwiseErrors errors = meter.pointwise(image);
    EXPECT_NEAR(*errors[Metric::Rmse] / 2e-25, 1, 1e-6);
    EXPECT_NEAR(*errors[Metric::Mae] / 2e-25, 1, 1e-6);
    EXPECT_NEAR(*errors.channels(Metric::Bias)[1] / 2e-25, 1, 1e-6);
    for (const Metric metric : {Metric::RelativeMse, Metric::FittedRelativeMse, Metric::Smape, Metric::Percentiles}) {
        std::string why;
        EXPECT_TRUE(meter.measure(metric, image, &why).empty());
        EXPECT_EQ(why, "the mean of the reference is 0");
        EXPECT_TRUE(meter.measure(metric, image).empty());
    }
    EXPECT_EQ(meter.measure(Metric::Bias, image).size(), 3u);

    const ErrorMeter red(Size2{1, 1}, {1, 0, 1});
    std::string why;
    EXPECT_TRUE(red.measure(Metric::RelativeBias, Image{1, 1, 1}, &why).empty());
    EXPECT_EQ(why, "the mean of the reference is 0 in channel G");
    EXPECT_DOUBLE_EQ(*red.pointwise(Image{3, 1, 1}).channels(Metric::RelativeBias)[0], 2);
}

TEST(ErrorMeter, ValuesOfOneSweepAreThoseMeasured) {
    const Pair pair({31, 9}, 41);
    const ErrorMeter meter(pair.size, pair.reference);
    const PointwiseErrors errors = meter.pointwise(pair.image);
    for (const MetricInfo& info : kMetrics) {
        if (!info.needs_reference || info.costly) continue;
        const std::vector<double> values = errors.values_of(info.metric);
        EXPECT_EQ(values.size(), info.values) << info.name;
        EXPECT_EQ(values, meter.measure(info.metric, pair.image)) << info.name;
    }
    EXPECT_EQ(errors.values_of(Metric::Mae), std::vector{*errors[Metric::Mae]});
    EXPECT_EQ(errors.values_of(Metric::Smape), std::vector{*errors[Metric::Smape]});
    EXPECT_EQ(errors.values_of(Metric::Bias)[2], *errors.channels(Metric::Bias)[2]);
}

TEST(ErrorMeter, PercentilesOfTenPixelsWorkedByHand) {
    // Reference 1 (m = 1): pixel k is off by 0.5 k in one channel: its error is 0.5 k / sqrt(3 x 1.01). Of ten pixels
    // 50 % are the first five, 90 % nine, 99 % take all ten.
    const Size2 size{10, 1};
    const ErrorMeter meter(size, constant(size, 1));
    Image image = constant(size, 1);
    for (const size_t k : {7, 2, 9, 1, 10, 4, 8, 3, 6, 5}) image[3 * (k - 1) + k % 3] += 0.5f * static_cast<float>(k);
    std::reverse(image.begin(), image.begin() + 15);
    const std::array<double, 4> found = *meter.percentiles(image);
    const double step = 0.5 / std::sqrt(3 * 1.01);
    EXPECT_NEAR(found[0], 5 * step, 1e-12);
    EXPECT_NEAR(found[1], 9 * step, 1e-12);
    EXPECT_NEAR(found[2], 10 * step, 1e-12);
    EXPECT_NEAR(found[3], 10 * step, 1e-12);
    // Reversing the first five pixels' values put pixel 5 first; without it and pixel 10 eight are left.
    image[0] = kNan, image[29] = kInfinity;
    const std::vector<double> each = meter.relative_errors(image);
    EXPECT_TRUE(std::isnan(each[0]) && std::isnan(each[9]));
    EXPECT_NEAR(each[7], 8 * step, 1e-12);
    const std::array<double, 4> of_eight = *meter.percentiles(image);  // errors of 1, 2, 3, 4, 6, 7, 8, 9 steps
    EXPECT_NEAR(of_eight[0], 4 * step, 1e-12);
    EXPECT_NEAR(of_eight[1], 9 * step, 1e-12);
}

TEST(ErrorMeter, PercentilesFollowTheDefinition) {
    for (const Size2 size : {Size2{1, 1}, {3, 1}, {10, 10}, {53, 29}, {101, 99}}) {
        const Pair pair = Pair(size, 51).with_specials(5, {kNan, kInfinity}, 200);
        const ErrorMeter meter(size, pair.reference);
        const Real floor = Real(0.01) * Real(meter.reference_mean()) * Real(meter.reference_mean());
        std::vector<double> errors;
        for (size_t pixel = 0; pixel < size.pixels(); ++pixel) {
            Real sum = 0;
            for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
                const Real x = pair.image[i], r = pair.reference[i];
                sum += std::isfinite(x) && std::isfinite(r) ? (x - r) * (x - r) / (r * r + floor) : Real(kInfinity);
            }
            if (std::isfinite(sum)) errors.push_back(static_cast<double>(std::sqrt(sum / 3)));
        }
        std::sort(errors.begin(), errors.end());
        const std::array<double, 4> found = *meter.percentiles(pair.image);
        for (size_t i = 0; i < 4; ++i) {
            const size_t percent[] = {50, 90, 99, 100};
            size_t smallest = 0;
            while (100 * (smallest + 1) < percent[i] * errors.size()) ++smallest;
            EXPECT_NEAR(found[i], errors[smallest], 1e-12 * errors[smallest])
                << percent[i] << " % of " << errors.size();
        }
    }
}

TEST(Fireflies, AreFarAboveTheMedianOfTheirNeighbours) {
    // Mean 1, neighbours 1: the limit is 100 x (1 + 0.01) = 101.
    const Size2 size{9, 7};
    const ErrorMeter meter(size, constant(size, 1));
    const auto count = [&](std::initializer_list<std::pair<size_t, float>> spots) {
        Image image = constant(size, 1);
        for (const auto& [pixel, value] : spots) std::fill_n(image.begin() + std::ptrdiff_t(3 * pixel), 3, value);
        return meter.firefly_count(image);
    };
    EXPECT_EQ(count({}), 0u);
    EXPECT_EQ(count({{31, 100.9f}}), 0u);
    EXPECT_EQ(count({{31, 101.1f}}), 1u);
    EXPECT_EQ(count({{0, 101.1f}, {8, 100.9f}, {62, 1e30f}}), 2u);  // corners
    EXPECT_EQ(count({{30, 500}, {31, 101.1f}, {32, kLargest}}), 3u);
    EXPECT_EQ(count({{31, kNan}, {30, kInfinity}, {32, -kInfinity}}), 0u);
    EXPECT_EQ(count({{31, kNan}, {30, 101.1f}, {32, -kInfinity}}), 1u);
}

TEST(Fireflies, MedianOfAnEvenNumberIsTheMeanOfTheTwoInTheMiddle) {
    // Neighbours 0 and 2: median 1, limit 101; 1 and 201 were it the lower or the upper.
    const Size2 size{3, 1};
    const ErrorMeter meter(size, constant(size, 1));
    EXPECT_EQ(meter.firefly_count(Image{0, 0, 0, 100.9f, 100.9f, 100.9f, 2, 2, 2}), 0u);
    EXPECT_EQ(meter.firefly_count(Image{0, 0, 0, 101.1f, 101.1f, 101.1f, 2, 2, 2}), 1u);
    const ErrorMeter lone(Size2{1, 1}, {1, 1, 1});
    EXPECT_EQ(lone.firefly_count(Image{1e9f, 1e9f, 1e9f}), 0u);  // there is nothing to be above of
}

uint64_t fireflies_by_definition(const Pair& pair, double mean) {
    const auto [width, height] = pair.size;
    const auto color = [&](size_t x, size_t y) {
        const float* pixel = &pair.image[3 * (y * width + x)];
        return Rgb(pixel[0], pixel[1], pixel[2]);
    };
    uint64_t count = 0;
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            std::vector<double> around;
            for (size_t j = y - std::min<size_t>(y, 2); j < std::min<size_t>(height, y + 3); ++j)
                for (size_t i = x - std::min<size_t>(x, 2); i < std::min<size_t>(width, x + 3); ++i)
                    if ((i != x || j != y) && is_finite(color(i, j))) around.push_back(luminance(color(i, j)));
            if (around.empty() || !is_finite(color(x, y))) continue;
            std::sort(around.begin(), around.end());
            const double median = 0.5 * (around[(around.size() - 1) / 2] + around[around.size() / 2]);
            if (luminance(color(x, y)) > 100 * (median + 0.01 * mean)) ++count;
        }
    return count;
}

TEST(Fireflies, FollowTheDefinitionOnRandomImages) {
    uint64_t seed = 0, total = 0;
    for (const Size2 size : {Size2{1, 2}, {2, 5}, {7, 3}, {1, 40}, {61, 47}, {130, 90}}) {
        Pair pair = Pair(size, ++seed);
        RandomStream random(seed, RandomDomain::Test, 2, 0);
        for (size_t pixel = 0; pixel < size.pixels(); ++pixel) {  // luminances over seven magnitudes: many stand out
            const float magnitude = std::exp(16 * random.next() - 8) * (random.next() < 0.05f ? -0.01f : 1.0f);
            for (size_t k = 0; k < 3; ++k) pair.image[3 * pixel + k] = magnitude * (0.5f + random.next());
        }
        pair.with_specials(seed, {kNan, kInfinity, 0.0f}, 30);
        const ErrorMeter meter(size, pair.reference);
        const uint64_t expected = fireflies_by_definition(pair, meter.reference_mean());
        EXPECT_EQ(meter.firefly_count(pair.image), expected) << size.width << " x " << size.height;
        total += expected;
    }
    EXPECT_GT(total, 100u);  // there was something to find
}

TEST(ErrorMeter, GivesTheSameBitsOnAnyNumberOfThreads) {
    const Pair pair = Pair({301, 203}, 61).with_specials(6, {kNan, kLargest, kInfinity}, 20000);
    const auto is_sum = [](const MetricInfo& info) {
        return info.needs_reference && info.metric != Metric::FlipLdr && info.metric != Metric::FlipHdr;
    };
    const auto measured = [&](int threads) {
        return test::on_threads(threads, [&] {
            const ErrorMeter meter(pair.size, pair.reference);
            std::vector<double> values{meter.reference_mean()};
            for (const MetricInfo& info : kMetrics)
                if (is_sum(info))
                    for (const double value : meter.measure(info.metric, pair.image)) values.push_back(value);
            return values;
        });
    };
    const std::vector<double> one = measured(1);
    size_t expected = 1;
    for (const MetricInfo& info : kMetrics) expected += is_sum(info) ? info.values : 0;
    ASSERT_EQ(one.size(), expected);
    for (const int threads : {2, 3, 8}) {
        const std::vector<double> many = measured(threads);
        ASSERT_EQ(many.size(), one.size());
        EXPECT_EQ(std::memcmp(many.data(), one.data(), one.size() * sizeof(double)), 0) << threads;
    }
}

TEST(ErrorMeter, FlipIsThatOfFlipAlsoWhenTwoAskAtOnce) {
    const Pair pair({40, 30}, 71);
    const ErrorMeter meter(pair.size, pair.reference);
    std::vector<double> ldr, hdr;
    std::thread other([&] { ldr = meter.measure(Metric::FlipLdr, pair.image); });
    const FlipMap map = meter.flip_ldr(pair.image);
    hdr = meter.measure(Metric::FlipHdr, pair.image);
    other.join();
    const FlipMap expected = Flip(pair.size, pair.reference, FlipRange::Ldr).measure(pair.image);
    EXPECT_EQ(map.values, expected.values);
    EXPECT_EQ(ldr, std::vector{expected.mean});
    EXPECT_EQ(hdr, std::vector{Flip(pair.size, pair.reference, FlipRange::Hdr).measure(pair.image).mean});
    EXPECT_EQ(meter.flip_hdr(pair.image).mean, hdr[0]);
    EXPECT_NE(hdr, ldr);
}

}  // namespace
}  // namespace photond::error_meter_test

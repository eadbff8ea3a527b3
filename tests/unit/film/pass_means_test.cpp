// What passes say of an image's mean is the spread between passes, whatever pixels share within one, and the same bits
// however the passes are cut and ordered.

#include "renderer/film/pass_means.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "renderer/core/rng.h"
#include "renderer/film/film.h"
#include "tests/support/random_film.h"
#include "tests/support/threads.h"

namespace photond::pass_means_test {
namespace {

using test::film_of;
using test::film_of_range;
using Of = PassMeans::Of;

FixedSquares random_bits(RandomStream& random) {
    FixedSquares bits = 0;
    for (int i = 0; i < 4; ++i) bits = bits << 32 | random.next_bits();
    return bits;
}

TEST(WideSquares, LoseNothing) {
    RandomStream random(11, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 20000; ++i) {  // (a + b)^2 + (a - b)^2 = 2 a^2 + 2 b^2
        const FixedSum a = static_cast<FixedSum>(random_bits(random) >> (2 + i % 70)) * (i % 2 ? -1 : 1);
        const FixedSum b = static_cast<FixedSum>(random_bits(random) >> (2 + i % 71));
        WideSquares left = exact_square(a + b), right = times(exact_square(a), 2);
        left += exact_square(a - b);
        right += times(exact_square(b), 2);
        ASSERT_EQ(left, right) << i;
    }
    const FixedSum sum = (FixedSum{1} << 100) + 1;  // (2^100 + 1)^2 = 2^200 + 2^101 + 1
    EXPECT_EQ(exact_square(-sum), (WideSquares{FixedSquares{1} << 72, (FixedSquares{1} << 101) + 1}));
    const WideSquares ones{0, ~FixedSquares{0}};  // (2^128 - 1) 3 = 2 2^128 + 2^128 - 3
    EXPECT_EQ(times(ones, 3), (WideSquares{2, ~FixedSquares{0} - 2}));
    EXPECT_EQ(times(WideSquares{5, 0}, 7), (WideSquares{35, 0}));
}

// --- What they say

/// What the formula makes of pixels that takes them to be independent.
double pixel_standard_error(const Film& film) {
    double variance = 0;
    const std::vector<float> of_pixels = film.pass_variance_beauty();
    for (size_t i = 0; i < of_pixels.size(); i += 3) variance += double{of_pixels[i]} / film.passes();
    return std::sqrt(variance) / static_cast<double>(film.size().pixels());
}

double standard_error(const Film& film, Of image = Of::Beauty, size_t channel = 0) {
    return std::sqrt(film.pass_means().variance(image).value().at(channel) / film.passes());
}

/// Of a quantity that is uniform over an interval of length 1, as an estimate of its standard deviation from n values
/// is: with kurtosis 9/5 the variance's estimate has the relative deviation sqrt((9/5 - 1) / n), its root half of that.
/// 5.2 deviations: passed once in 5 million times.
double uniform_tolerance(uint32_t n) { return 5.2 * 0.5 * std::sqrt(0.8 / n); }

constexpr uint32_t kPasses = 2000;
constexpr Size2 kSize{20, 5};

/// Each pixel 1 times the pass's factor, uniform from 0.5 to 1.5.
TEST(PassMeans, PixelsThatShareAPasssFactorAreNotIndependent) {
    Film film(kSize, LayerSet());
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        const float factor = 0.5f + RandomStream(21, RandomDomain::Test, pass, 0).next();
        PassImage image(kSize, LayerSet());
        for (Rgb& color : image.of<Layer::Direct>()) color = Rgb(factor, 0.5f, 0);
        for (Rgb& color : image.of<Layer::Indirect>()) color = Rgb(1 - factor, 2 * factor, factor);
        film.add_pass(image);
    }
    const double expected = std::sqrt(1.0 / 12 / kPasses);
    EXPECT_NEAR(standard_error(film, Of::Direct, 0), expected, uniform_tolerance(kPasses) * expected);
    EXPECT_EQ(standard_error(film, Of::Direct, 1), 0);
    EXPECT_NEAR(standard_error(film, Of::Indirect, 1), 2 * expected, uniform_tolerance(kPasses) * 2 * expected);
    // Of the beauty: red does not vary but by the floats' rounding, green as indirect, blue too.
    EXPECT_LT(standard_error(film, Of::Beauty, 0), 1e-6 * expected);
    EXPECT_DOUBLE_EQ(standard_error(film, Of::Beauty, 1), standard_error(film, Of::Indirect, 1));
    EXPECT_DOUBLE_EQ(standard_error(film, Of::Beauty, 2), standard_error(film, Of::Indirect, 2));
    // The mean is within it of the truth, 2 x 1 + 0.5, and would not be within what 100 pixels feign by as many passes.
    const double off = std::fabs(double{film.resolve_beauty()[1]} - 2.5);
    EXPECT_LT(off, 5.2 * standard_error(film, Of::Beauty, 1));
}

TEST(PassMeans, APixelFormulaIsTenTimesTooSmallOverAHundredPixelsThatShare) {
    Film shared(kSize, LayerSet()), independent(kSize, LayerSet());
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        RandomStream random(22, RandomDomain::Test, pass, 0);
        PassImage image(kSize, LayerSet());
        const float factor = 0.5f + random.next();
        for (Rgb& color : image.of<Layer::Direct>()) color = Rgb(factor);
        shared.add_pass(image);
        for (Rgb& color : image.of<Layer::Direct>()) color = Rgb(0.5f + random.next());
        independent.add_pass(image);
    }
    EXPECT_NEAR(standard_error(shared) / pixel_standard_error(shared), 10, 1e-5) << "the same values, summed otherwise";
    const double expected = std::sqrt(1.0 / 12 / kPasses / 100);
    // The mean of 100 is all but normal: its kurtosis, 3, makes its variance's estimate deviate by sqrt(2 / n).
    EXPECT_NEAR(standard_error(independent), expected, 5.2 * 0.5 * std::sqrt(2.0 / kPasses) * expected);
    EXPECT_NEAR(pixel_standard_error(independent), expected, 0.1 * uniform_tolerance(kPasses) * expected);
}

TEST(PassMeans, AreTheVarianceOfTheImagesMeans) {
    const Size2 size{37, 11};
    constexpr uint32_t kFew = 12;
    double sums[3][3] = {}, squares[3][3] = {};
    for (uint32_t p = 0; p < kFew; ++p) {
        const PassImage pass = test::random_pass(size, LayerSet(), p);
        for (int k = 0; k < 3; ++k) {
            double means[3] = {};
            for (size_t i = 0; i < size.pixels(); ++i) {
                const double direct = double{pass.of<Layer::Direct>()[i][k]};
                const double indirect = double{pass.of<Layer::Indirect>()[i][k]};
                means[0] += double{pass.of<Layer::Emitted>()[i][k]} + direct + indirect;
                means[1] += direct, means[2] += indirect;
            }
            for (int image = 0; image < 3; ++image) {
                const double mean = means[image] / static_cast<double>(size.pixels());
                sums[image][k] += mean, squares[image][k] += mean * mean;
            }
        }
    }
    const Film film = film_of_range(size, LayerSet(), 0, kFew);
    EXPECT_EQ(film.pass_means().passes(), kFew);
    for (const Of image : {Of::Beauty, Of::Direct, Of::Indirect})
        for (size_t k = 0; k < 3; ++k) {
            const double sum = sums[static_cast<size_t>(image)][k];
            const double expected = (squares[static_cast<size_t>(image)][k] - sum * sum / kFew) / (kFew - 1);
            EXPECT_NEAR(film.pass_means().variance(image)->at(k), expected, 1e-9 * expected);
        }
}

// In units of 2^-64 the square of such a mean is 0.
TEST(PassMeans, KnowTheSpreadOfADarkImage) {
    Film film({2, 2}, LayerSet());
    for (int pass = 0; pass < 4; ++pass) {
        PassImage image({2, 2}, LayerSet());
        for (Rgb& color : image.of<Layer::Direct>()) color = Rgb(0x1p-40f * static_cast<float>(pass % 2));
        film.add_pass(image);
    }
    EXPECT_DOUBLE_EQ(film.pass_means().variance(Of::Beauty)->at(0), 0x1p-80 / 3);
}

TEST(PassMeans, WhatIsDroppedCountsAsZero) {
    Film film({4, 1}, LayerSet());
    for (const float bad : {std::nanf(""), kInfinity, 3.0f}) {
        PassImage image({4, 1}, LayerSet());
        for (Rgb& color : image.of<Layer::Direct>()) color = Rgb(3);
        image.of<Layer::Direct>()[1] = Rgb(3, bad, 3);
        film.add_pass(image);
    }
    // The means are 9/4, 9/4 and 3 in all channels, for a pixel is dropped whole: variance 2/3 (3/4)^2 / 2.
    for (size_t k = 0; k < 3; ++k) EXPECT_DOUBLE_EQ(film.pass_means().variance(Of::Direct)->at(k), 3.0 / 16);
}

TEST(PassMeans, OfOnePassOrNoneSayNothing) {
    Film film({3, 3}, LayerSet());
    EXPECT_EQ(film.pass_means().variance(Of::Beauty), std::nullopt);
    film.add_pass(test::random_pass({3, 3}, LayerSet(), 0));
    EXPECT_EQ(film.pass_means().variance(Of::Beauty), std::nullopt);
    film.add_pass(test::random_pass({3, 3}, LayerSet(), 1));
    EXPECT_GT(film.pass_means().variance(Of::Beauty)->at(0), 0);
}

// --- The same bits

TEST(PassMeans, AnyOrderCutAndNumberOfThreadsGivesTheSameBits) {
    const Size2 size{256, 64};  // more than one range a pass
    constexpr uint32_t kSome = 12;
    const PassMeans whole = test::on_threads(1, [&] { return film_of_range(size, LayerSet(), 0, kSome).pass_means(); });
    EXPECT_TRUE(whole == test::on_threads(7, [&] { return film_of_range(size, LayerSet(), 0, kSome).pass_means(); }));
    std::vector<uint32_t> order(kSome);
    for (uint32_t pass = 0; pass < kSome; ++pass) order[pass] = (7 * pass + 3) % kSome;
    EXPECT_TRUE(whole == film_of(size, LayerSet(), order).pass_means());
    std::mt19937 shuffled(5);
    for (const uint32_t cuts : {2u, 5u, kSome}) {
        std::vector<Film> parts;
        for (uint32_t i = 0; i < cuts; ++i)
            parts.push_back(film_of_range(size, LayerSet(), kSome * i / cuts, kSome * (i + 1) / cuts));
        std::shuffle(parts.begin(), parts.end(), shuffled);
        for (size_t i = 1; i < parts.size(); ++i) parts[0].merge(parts[i]);
        EXPECT_TRUE(whole == parts[0].pass_means()) << cuts;
    }
    order[0] = 99;  // another pass: the comparison can fail
    EXPECT_FALSE(whole == film_of(size, LayerSet(), order).pass_means());
}

TEST(PassMeans, ComeBackFromTheirBytes) {
    const PassMeans means = film_of_range({5, 3}, LayerSet(), 0, 9).pass_means();
    const std::string bytes = means.bytes();
    EXPECT_EQ(PassMeans::from_bytes(bytes), means);
    EXPECT_EQ(PassMeans::from_bytes(bytes.substr(1)), std::nullopt);
    EXPECT_EQ(PassMeans::from_bytes(bytes + "x"), std::nullopt);
    for (size_t at = 0; at < bytes.size(); ++at) {
        std::string changed = bytes;
        changed[at] = static_cast<char>(changed[at] ^ 1);
        EXPECT_FALSE(PassMeans::from_bytes(changed) == means) << "byte " << at;
    }
}

}  // namespace
}  // namespace photond::pass_means_test

#include "renderer/error/flip.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "renderer/error/flip_exposures.h"
#include "renderer/error/flip_features.h"
#include "tests/support/direct_flip.h"
#include "tests/support/threads.h"

namespace photond::flip_test {
namespace {

namespace direct = test::direct_flip;

std::vector<float> flat(Size2 size, float value) { return std::vector<float>(3 * size.pixels(), value); }

std::vector<float> noise(Size2 size, unsigned seed, float scale = 1) {
    std::mt19937 generator(seed);
    std::vector<float> image(3 * size.pixels());
    for (float& value : image) value = scale * static_cast<float>(generator()) / 4294967296.0f;
    return image;
}

/// Coloured stripes, a bright disc over a ramp, and a dark part.
std::vector<float> structure(Size2 size, float shift) {
    std::vector<float> image;
    for (uint32_t j = 0; j < size.height; ++j)
        for (uint32_t i = 0; i < size.width; ++i) {
            const float x = static_cast<float>(i) + shift, y = static_cast<float>(j);
            const bool disc = std::hypot(x - 14, y - 12) < 7;
            image.push_back(disc ? 3.0f : 0.02f * x);
            image.push_back(i / 3 % 2 == 0 ? 0.4f : 0.02f + 0.01f * y);
            image.push_back(j > 20 ? 0.003f : 0.6f + 0.3f * std::sin(0.7f * x));
        }
    return image;
}

direct::Image direct_image(Size2 size, const std::vector<float>& image, double largest) {
    direct::Image result{static_cast<int>(size.width), static_cast<int>(size.height), {}};
    const auto shown = [&](float value) { return std::clamp(double{value}, 0.0, largest); };
    for (size_t i = 0; i < image.size(); i += 3)
        result.pixels.push_back({shown(image[i]), shown(image[i + 1]), shown(image[i + 2])});
    return result;
}

/// Largest and mean difference of a map from the direct answer.
void expect_near_direct(const FlipMap& map, const std::vector<double>& exact) {
    ASSERT_EQ(map.values.size(), exact.size());
    double largest = 0, mean = 0;
    for (size_t i = 0; i < exact.size(); ++i) {
        largest = std::max(largest, std::fabs(double{map.values[i]} - exact[i]));
        mean += exact[i] / static_cast<double>(exact.size());
    }
    EXPECT_LT(largest, kFlipLargestError);
    EXPECT_NEAR(map.mean, mean, kFlipMeanError);
}

TEST(FlipLdr, IsTheDefinition) {
    const Size2 size{41, 37};
    const auto expect = [&](const std::vector<float>& reference, const std::vector<float>& test, float ppd) {
        const FlipMap map = Flip(size, reference, FlipRange::Ldr, ppd).measure(test);
        expect_near_direct(map,
                           direct::ldr(direct_image(size, reference, 1), direct_image(size, test, 1), double{ppd}));
    };
    expect(noise(size, 1), noise(size, 2), kFlipPixelsPerDegree);
    expect(structure(size, 0), structure(size, 1.3f), kFlipPixelsPerDegree);
    std::vector<float> noisy = structure(size, 0);
    const std::vector<float> amount = noise(size, 3, 0.2f);
    for (size_t i = 0; i < noisy.size(); ++i) noisy[i] *= 0.9f + amount[i];
    expect(structure(size, 0), noisy, kFlipPixelsPerDegree);
    expect(structure(size, 0), noisy, 20.5f);
}

TEST(FlipLdr, IsTheDefinitionOnImagesOfOnePixelAndOneRow) {
    for (const Size2 size : {Size2{1, 1}, Size2{37, 1}, Size2{1, 70}}) {
        const std::vector<float> reference = noise(size, 4), test = noise(size, 5);
        const FlipMap map = Flip(size, reference, FlipRange::Ldr).measure(test);
        expect_near_direct(map, direct::ldr(direct_image(size, reference, 1), direct_image(size, test, 1),
                                            double{kFlipPixelsPerDegree}));
    }
}

TEST(FlipHdr, IsTheDefinition) {
    const Size2 size{33, 26};
    std::vector<float> reference = structure(size, 0), test = structure(size, 0.7f);
    for (size_t i = 300; i < 330; ++i) reference[i] = 40;  // a light
    const Flip flip(size, reference, FlipRange::Hdr);
    EXPECT_GT(flip.exposures().size(), 3u);
    expect_near_direct(flip.measure(test),
                       direct::hdr(direct_image(size, reference, 1e9), direct_image(size, test, 1e9), flip.exposures(),
                                   double{kFlipPixelsPerDegree}));
}

TEST(Flip, IdenticalImagesDifferByExactlyNothing) {
    const Size2 size{70, 67};
    for (const FlipRange range : {FlipRange::Ldr, FlipRange::Hdr}) {
        const std::vector<float> image = noise(size, 6, 4);
        for (const uint64_t cache : {kFlipCacheBytes, uint64_t{0}}) {
            const FlipMap map = Flip(size, image, range, kFlipPixelsPerDegree, cache).measure(image);
            EXPECT_EQ(map.mean, 0);
            for (const float value : map.values) EXPECT_EQ(value, 0);
        }
    }
}

TEST(FlipLdr, BlackAgainstWhite) {
    const Size2 size{24, 24};
    const FlipMap map = Flip(size, flat(size, 0), FlipRange::Ldr).measure(flat(size, 1));
    // No features; HyAB = 100, 100^0.7 = 25.119; largest 203.3^0.7 = 41.29, knee 16.52:
    // 0.95 + 0.05 (25.119 - 16.52) / (41.29 - 16.52).
    for (const float value : map.values) EXPECT_NEAR(value, 0.96736, 2e-4);
    EXPECT_NEAR(map.mean, 0.96736, 2e-4);
}

TEST(FlipLdr, ExchangingTheImagesChangesNothing) {
    const Size2 size{50, 40};
    const std::vector<float> a = structure(size, 0), b = noise(size, 7);
    EXPECT_EQ(Flip(size, a, FlipRange::Ldr).measure(b).values, Flip(size, b, FlipRange::Ldr).measure(a).values);
}

TEST(FlipLdr, AChangedPixelIsSeenAsFarAsTheFiltersReach) {
    const Size2 size{45, 80};
    const std::vector<float> reference = flat(size, 0.2f);
    std::vector<float> test = reference;
    constexpr int kX = 22, kY = 63;            // at the end of a strip
    test[3 * (kY * size.width + kX) + 2] = 1;  // blue, the widest filter
    const FlipMap map = Flip(size, reference, FlipRange::Ldr).measure(test);
    for (int y = 0; y < int(size.height); ++y)
        for (int x = 0; x < int(size.width); ++x) {
            const float value = map.values[static_cast<size_t>(y) * size.width + static_cast<size_t>(x)];
            // Colours are filtered over 10 pixels, features (of the unfiltered image) over 9: the larger.
            if (std::max(std::abs(x - kX), std::abs(y - kY)) > 10) {
                EXPECT_EQ(value, 0) << x << ' ' << y;
            } else if (x == kX || y == kY) {
                EXPECT_GT(value, 0) << x << ' ' << y;
            }
        }
}

TEST(Flip, ValuesOutsideTheRangeOfAnImage) {
    const Size2 size{30, 30};
    const float kNan = std::nanf("");
    for (const FlipRange range : {FlipRange::Ldr, FlipRange::Hdr}) {
        std::vector<float> clean = structure(size, 0), odd = clean;
        for (size_t i = 0; i < 40; ++i) {
            clean[5 * i] = 0;
            odd[5 * i] = std::array{kNan, kInfinity, -kInfinity, -3.0f}[i % 4];
        }
        const std::vector<float> test = structure(size, 1);
        EXPECT_EQ(Flip(size, clean, range).measure(test).values, Flip(size, odd, range).measure(test).values);
        EXPECT_EQ(Flip(size, test, range).measure(clean).values, Flip(size, test, range).measure(odd).values);
    }
    // Scene-linear values above 1 are white to the LDR form, and differ to the HDR form.
    const std::vector<float> bright = flat(size, 4), brighter = flat(size, 8);
    EXPECT_EQ(Flip(size, bright, FlipRange::Ldr).measure(brighter).mean, 0);
    EXPECT_GT(Flip(size, bright, FlipRange::Hdr).measure(brighter).mean, 0.05);
}

TEST(FlipHdr, ExposuresOfAConstructedReference) {
    const auto grey = [](std::initializer_list<float> luminances) {
        std::vector<float> image;
        for (const float y : luminances) image.insert(image.end(), 3, y);
        return image;
    };
    const auto expect = [](const std::vector<float>& exposures, const std::vector<float>& expected) {
        ASSERT_EQ(exposures.size(), expected.size());
        for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(exposures[i], expected[i], 1e-3) << i;
    };
    // The tone curve is 0.85 at 2.1189, log2 of which is 1.0833. Largest 12, median 1: 3.585 stops, four exposures.
    expect(flip_exposures(grey({0.25f, 12, 1, 0.5f, 2})), {-2.5017f, -1.3067f, -0.1117f, 1.0833f});
    // Of an even number the median is the mean of the middle two, 1.5; less than two stops apart, two exposures.
    expect(flip_exposures(grey({1, 2, 5, 0})), {1.0833f - std::log2(5.0f), 1.0833f - std::log2(1.5f)});
    // More than half black: the median of the rest, 1.
    expect(flip_exposures(grey({0, 0, 0, 0, 1, 0.5f, 4})), {-0.9167f, 1.0833f});
    expect(flip_exposures(grey({0, 0, 1e-40f})), {0});
    expect(flip_exposures(grey({3, 3, 3})), {1.0833f - std::log2(3.0f)});
    expect(flip_exposures({}), {0});
    // Luminance: of pure green 0.7152.
    expect(flip_exposures(std::vector<float>{0, 2, 0}), {1.0833f - std::log2(2 * 0.7152f)});
    // The extremes of floats.
    for (const float exposure : flip_exposures(grey({3e38f, 2e-38f, 1e-38f})))
        EXPECT_TRUE(std::isfinite(std::exp2(exposure)));
}

TEST(FlipHdr, ABlackReferenceIsComparedUnexposed) {
    const Size2 size{12, 12};
    const Flip flip(size, flat(size, 0), FlipRange::Hdr);
    EXPECT_EQ(flip.exposures(), std::vector<float>{0});
    EXPECT_EQ(flip.measure(flat(size, 0)).mean, 0);
    EXPECT_GT(flip.measure(flat(size, 0.5f)).mean, 0.5);
}

TEST(Flip, ThreadsAndCacheDoNotChangeABit) {
    const Size2 size{53, 200};
    const std::vector<float> reference = noise(size, 8, 3), test = noise(size, 9, 3);
    for (const FlipRange range : {FlipRange::Ldr, FlipRange::Hdr}) {
        const auto measured = [&](int threads, uint64_t cache) {
            return test::on_threads(threads, [&] {
                const Flip flip(size, reference, range, kFlipPixelsPerDegree, cache);
                EXPECT_LE(flip.bytes(), cache + 12 * size.pixels());
                return flip.measure(test);
            });
        };
        const FlipMap one = measured(1, kFlipCacheBytes);
        const uint64_t room_for_one_exposure = FeatureRow::floats(size.width) * sizeof(float) * size.height;
        for (const uint64_t cache : {kFlipCacheBytes, room_for_one_exposure, uint64_t{0}}) {
            const FlipMap many = measured(4, cache);
            EXPECT_EQ(one.values, many.values);
            EXPECT_EQ(one.mean, many.mean);
        }
        EXPECT_NEAR(one.mean, std::accumulate(one.values.begin(), one.values.end(), 0.0) / double(size.pixels()),
                    1e-12);
    }
}

TEST(FlipPool, ByHand) {
    // Weights 0.1 + 0.2 + 0.3 + 0.4 = 1: a quarter of it is reached by 0.2 (0.3), half by 0.3 (0.6), 0.75 by 0.4.
    const FlipPool pool = pool_flip(std::vector<float>{0.3f, 0.1f, 0.4f, 0.2f});
    EXPECT_NEAR(pool.mean, 0.25, 1e-7);
    EXPECT_EQ(pool.weighted_first_quartile, double{0.2f});
    EXPECT_EQ(pool.weighted_median, double{0.3f});
    EXPECT_EQ(pool.weighted_third_quartile, double{0.4f});
    EXPECT_EQ(pool.minimum, double{0.1f});
    EXPECT_EQ(pool.maximum, double{0.4f});
    // Zeros have no weight, however many.
    std::vector<float> sparse(1000, 0.0f);
    sparse[17] = 0.5f;
    EXPECT_EQ(pool_flip(sparse).weighted_first_quartile, 0.5);
    EXPECT_EQ(pool_flip(sparse).mean, 0.0005);
    EXPECT_EQ(pool_flip(std::vector<float>(9, 0.0f)).weighted_median, 0);
    EXPECT_EQ(pool_flip({}).mean, 0);
}

}  // namespace
}  // namespace photond::flip_test

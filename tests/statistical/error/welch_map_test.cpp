// The Welch map keeps its level where nothing is biased, finds what its header says it finds, and tells heavy-tailed
// noise from the noise of diffuse light.
//
// Each range leaves room for what a binomial number of so many runs scatters with a probability of 1e-6.

#include "renderer/error/welch_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

#include "renderer/core/parallel.h"
#include "tests/support/statistics.h"

namespace photond::welch_map_statistics {
namespace {

constexpr double kFalseAlarm = 1e-6;

// 64 blocks of 16 pixels: what counts is the standard error of a block, whatever its pixels are.
constexpr uint32_t kBlock = 4;
constexpr Size2 kSize{8 * kBlock, 8 * kBlock};
constexpr size_t kBlocks = 64;

struct Noise {
    double film = 0, pattern = 0, reference = 0;  // of a pixel; of the whole film at once; of a pixel of each reference
};

class Images {
public:
    Images(const Noise& noise, uint64_t seed) : noise_(noise), random_(seed) {}

    /// `bias`: of the block in the middle.
    std::vector<float> film(double bias) {
        const double pattern = noise_.pattern * normal_(random_);
        std::vector<float> image = grey(noise_.film);
        for (size_t pixel = 0; pixel < kSize.pixels(); ++pixel) {
            const size_t x = pixel % kSize.width, y = pixel / kSize.width;
            const bool biased = x / kBlock == 4 && y / kBlock == 4;
            for (size_t channel = 0; channel < 3; ++channel)
                image[3 * pixel + channel] += static_cast<float>(pattern + (biased ? bias : 0));
        }
        return image;
    }
    std::vector<float> reference() { return grey(noise_.reference); }

private:
    std::vector<float> grey(double noise) {
        std::vector<float> image(3 * kSize.pixels());
        for (size_t i = 0; i < image.size(); i += 3)
            image[i] = image[i + 1] = image[i + 2] = static_cast<float>(1 + noise * normal_(random_));
        return image;
    }

    const Noise noise_;
    std::mt19937_64 random_;
    std::normal_distribution<double> normal_;
};

WelchMap map_of(const Noise& noise, size_t seeds, double bias, uint64_t seed) {
    Images images(noise, seed);
    const CrossMeter references(kSize, images.reference(), images.reference());
    std::vector<std::vector<float>> films;
    for (size_t i = 0; i < seeds; ++i) films.push_back(images.film(bias));
    return welch_map(references, films, kBlock);
}

TEST(WelchMapStatistics, KeepsItsLevelWhereNothingIsBiased) {
    constexpr size_t kRuns = 200;
    const double z = test::two_sided_z(kFalseAlarm);
    const Noise kinds[] = {{0.3, 0, 0.01}, {0.3, 0, 0.3}, {0.1, 0.02, 0.1}};
    for (const Noise& noise : kinds)
        for (const size_t seeds : {2, 3, 8}) {
            std::atomic<size_t> called_biased = 0, below_level = 0;
            parallel_for(kRuns, 8, [&](size_t run) {
                const WelchMap map = map_of(noise, seeds, 0, 1000 * seeds + run);
                called_biased += map.found > 0;
                below_level += static_cast<size_t>(std::lround(map.share_below_level * kBlocks));
            });
            std::printf("%zu seeds: %.1f %% of images called biased, %.2f %% of blocks below the level\n", seeds,
                        100.0 * double(called_biased) / kRuns, 100.0 * double(below_level) / (kRuns * kBlocks));
            const auto most = [&](double share, size_t trials) {
                return share + z * std::sqrt(share * (1 - share) / static_cast<double>(trials));
            };
            EXPECT_LE(double(called_biased) / kRuns, most(WelchMap::kLevel, kRuns));
            // Blocks share their pattern: no more than the runs is known to be independent of them.
            EXPECT_LE(double(below_level) / (kRuns * kBlocks),
                      most(WelchMap::kLevel, noise.pattern > 0 ? kRuns : kRuns * kBlocks));
        }
}

TEST(WelchMapStatistics, FindsABiasOfOnePerCentInOneBlock) {
    constexpr double kStandardError = 0.0018;
    constexpr size_t kRuns = 200;
    struct Case {
        size_t seeds;
        double of_reference;  // share of the variance
        double power;         // as the header has it
    };
    const double pixels = kBlock * kBlock, z = test::two_sided_z(kFalseAlarm);
    for (const Case& c : {Case{WelchMap::kSeedsToTell, 0.0, 0.9}, Case{20, 0.0, 0.78}, Case{8, 0.75, 0.75}}) {
        const double variance = kStandardError * kStandardError * pixels;
        const Noise noise{std::sqrt(variance * (1 - c.of_reference) * static_cast<double>(c.seeds)), 0,
                          std::sqrt(variance * c.of_reference * 2)};
        std::atomic<size_t> found = 0;
        parallel_for(kRuns, 8, [&](size_t run) {
            found += map_of(noise, c.seeds, 0.01, 77'000 * c.seeds + run).blocks[8 * 4 + 4].found;
        });
        const double share = double(found) / kRuns;
        std::printf("%zu seeds, %.0f %% of the variance the reference's: found in %.1f %%\n", c.seeds,
                    100 * c.of_reference, 100 * share);
        EXPECT_GE(share, c.power - z * std::sqrt(c.power * (1 - c.power) / kRuns));
    }
}

/// Noise of mean 0, in a pixel's light.
using Draw = std::function<double(std::mt19937_64&)>;

/// 64 x 64 pixels whose light varies over the image and has an edge.
std::vector<float> lit_image(double noise, const Draw& draw, std::mt19937_64& random) {
    constexpr uint32_t kWidth = 64;
    std::vector<float> values;
    for (uint32_t y = 0; y < kWidth; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
            const double light = (x > 20 ? 1 : 0.1) * (1.2 + std::sin(0.1 * y));
            values.insert(values.end(), 3, static_cast<float>(light * (1 + noise * draw(random))));
        }
    return values;
}

WelchMap map_of_noise(const Draw& draw, uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::vector<float> u = lit_image(0.02, draw, random), v = lit_image(0.02, draw, random);
    std::vector<std::vector<float>> films;
    for (int i = 0; i < 3; ++i) films.push_back(lit_image(0.1, draw, random));
    return welch_map(CrossMeter({64, 64}, u, v), films);
}

TEST(WelchMapStatistics, TellsHeavyTailsFromTheNoiseOfDiffuseLight) {
    std::normal_distribution<double> normal;
    std::exponential_distribution<double> exponential;
    std::uniform_real_distribution<double> uniform;
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        EXPECT_FALSE(map_of_noise([&](std::mt19937_64& random) { return normal(random); }, seed).heavy_tailed) << seed;
        // As a pixel of one path, or of few.
        EXPECT_FALSE(map_of_noise([&](std::mt19937_64& random) { return exponential(random) - 1; }, seed).heavy_tailed)
            << seed;
        // A path in two hundred is 200 times as bright.
        const WelchMap map = map_of_noise(
            [&](std::mt19937_64& random) { return normal(random) + (uniform(random) < 0.005 ? 199 : -1); }, seed);
        EXPECT_TRUE(map.heavy_tailed) << seed;
        EXPECT_NE(map.text().find("The noise is heavy-tailed: in 4 of 4 blocks 1 % of the pixels"), std::string::npos);
    }
}

}  // namespace
}  // namespace photond::welch_map_statistics

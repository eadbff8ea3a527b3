// The block test alarms as rarely as it says of sums that few heavy photons make, and notices a difference.

#include "tests/support/block_test.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"

namespace photond::test::block_test_test {
namespace {

constexpr size_t kBlocks = 4;

/// Passes whose blocks share photons: each of 40 photons falls, with 1 in 8, and brings its power, exponentially
/// distributed, to two blocks; in the first block `excess` times as much. Skewness 3 / sqrt(10 / sqrt(2)), of a sum of
/// some ten such powers.
BlockSums shared_photons(uint64_t render, size_t passes, double excess = 1) {
    BlockSums sums(1);
    RandomStream random(1, RandomDomain::Test, 0, render);
    for (size_t pass = 0; pass < passes; ++pass) {
        std::vector<double> blocks(3 * kBlocks);
        for (int photon = 0; photon < 40; ++photon) {
            const double power = random.next() < 0.125f ? -std::log(1 - double{random.next()}) : 0;
            const auto at = static_cast<size_t>(random.next() * float(kBlocks));
            for (const size_t block : {at, (at + 1) % kBlocks})
                for (size_t c = 0; c < 3; ++c) blocks[3 * block + c] += (block == 0 ? excess : 1) * power;
        }
        sums.add(std::move(blocks), kBlocks);
    }
    return sums;
}

TEST(BlockTest, AlarmsAsRarelyAsItSays) {
    // Blocks that share photons and channels that are one alarm together: the rate is below the stated one, never above
    // it. 4000 trials at 5 %: 6 standard deviations of the number of alarms are 83.
    constexpr size_t kTrials = 4000;
    size_t alarms = 0;
    for (uint64_t trial = 0; trial < kTrials; ++trial)
        alarms += compare_blocks(shared_photons(2 * trial, 16), shared_photons(2 * trial + 1, 16), 0.05).alarms > 0;
    EXPECT_LE(double(alarms), 0.05 * kTrials + 6 * std::sqrt(0.05 * 0.95 * kTrials));
    EXPECT_GE(alarms, kTrials / 400) << "a test that never alarms";
}

TEST(BlockTest, NoticesTheBlockThatDiffers) {
    const BlockTest same = compare_blocks(shared_photons(1, 400), shared_photons(2, 400));
    EXPECT_EQ(same.alarms, 0u) << same.table();
    EXPECT_LT(same.half_notice, 0.8);
    const BlockTest differs = compare_blocks(shared_photons(1, 400), shared_photons(2, 400, 2));
    EXPECT_EQ(differs.alarms, 3u) << differs.table();
    for (size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(differs.blocks[c].column, 0u);
        EXPECT_NEAR(differs.blocks[c].relative, 1, differs.blocks[c].noticed);
    }
}

TEST(BlockTest, LetsRoundingPassWhereNothingVaries) {
    BlockSums a(1), b(1), c(1);
    for (int pass = 0; pass < 4; ++pass) {
        a.add({100, 0, 1}, 1);
        b.add({100.0005, 0, 1}, 1);
        c.add({100.01, 0, 1}, 1);
    }
    EXPECT_EQ(compare_blocks(a, b).alarms, 0u);
    EXPECT_EQ(compare_blocks(a, c).alarms, 1u);
}

}  // namespace
}  // namespace photond::test::block_test_test

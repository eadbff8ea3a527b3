// Choices are made exactly as often as the distribution says: all 2^24 numbers are tried.

#include "renderer/transport/discrete_distribution.h"

#include <gtest/gtest.h>

#include <numeric>

#include "protocol/error.h"
#include "renderer/core/rng.h"

namespace photond::discrete_distribution_test {
namespace {

constexpr uint32_t kSteps = 1u << 24;

/// How often each entry is chosen by the numbers that RandomStream can give.
std::vector<uint32_t> count_choices(const DiscreteDistribution& distribution, size_t entries) {
    std::vector<uint32_t> counts(entries);
    for (uint32_t i = 0; i < kSteps; ++i) ++counts.at(distribution.sample(to_unit_float(i << 8)));
    return counts;
}

void expect_exact(const DiscreteDistribution& distribution, size_t entries) {
    const std::vector<uint32_t> counts = count_choices(distribution, entries);
    for (uint32_t i = 0; i < entries; ++i)
        ASSERT_EQ(counts[i], static_cast<double>(distribution.probability(i)) * kSteps) << "entry " << i;
}

TEST(DiscreteDistribution, ChoosesExactlyAsOftenAsItSays) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (const size_t entries : {1, 2, 3, 100, 5000}) {
        std::vector<double> weights(entries);
        for (double& weight : weights) weight = random.next() < 0.3f ? 0.0 : random.next();
        weights[entries / 2] = 1;
        const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
        const DiscreteDistribution distribution(weights);
        expect_exact(distribution, entries);
        for (uint32_t i = 0; i < entries; ++i) {
            if (weights[i] == 0) {
                EXPECT_EQ(distribution.probability(i), 0.0f);
            }
            EXPECT_NEAR(distribution.probability(i), weights[i] / total, 2.0 / kSteps + 1e-3 * weights[i] / total);
        }
    }
}

TEST(DiscreteDistribution, WeakEntriesKeepAStep) {
    const std::vector<double> weights = {1e-30, 0, 1e10, 1e-30, 0};
    const DiscreteDistribution distribution(weights);
    expect_exact(distribution, weights.size());
    EXPECT_EQ(distribution.probability(0), 1.0f / kSteps);
    EXPECT_EQ(distribution.probability(1), 0.0f);
    EXPECT_EQ(distribution.probability(3), 1.0f / kSteps);
    EXPECT_EQ(distribution.probability(4), 0.0f);
}

TEST(DiscreteDistribution, LeastProbabilitiesAreKept) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    constexpr uint32_t kEntries = 20000;
    std::vector<double> weights(kEntries), least(kEntries, 0.1 / kEntries);
    for (double& weight : weights) weight = random.next() < 0.9f ? 0.0 : random.next();
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    const DiscreteDistribution distribution(weights, least);
    expect_exact(distribution, kEntries);
    for (uint32_t i = 0; i < kEntries; ++i) {
        ASSERT_GE(distribution.probability(i), least[i]);
        // The least shares are rounded up to steps: a hundredth of all goes there instead of by weight.
        ASSERT_NEAR(distribution.probability(i), least[i] + 0.9 * weights[i] / total,
                    2.0 / kSteps + 0.01 * weights[i] / total);
    }
    // Without weights the least shares are all there is.
    const DiscreteDistribution even(least);
    for (uint32_t i = 0; i < kEntries; ++i) ASSERT_NEAR(even.probability(i), 1.0 / kEntries, 2.0 / kSteps);
}

TEST(DiscreteDistribution, NothingToChoose) {
    EXPECT_TRUE(DiscreteDistribution().empty());
    EXPECT_TRUE(DiscreteDistribution(std::vector<double>{}).empty());
    const DiscreteDistribution dark(std::vector<double>{0, 0});
    EXPECT_TRUE(dark.empty());
    EXPECT_EQ(dark.probability(1), 0.0f);
}

TEST(DiscreteDistribution, RefusesMoreEntriesThanSteps) {
    const std::vector<double> weights(DiscreteDistribution::kMost + 1, 1.0);
    EXPECT_THROW(DiscreteDistribution{weights}, Error);
}

TEST(DiscreteDistribution, EstimatesItsBytes) {
    for (const size_t entries : {1, 7, 100000}) {
        const DiscreteDistribution distribution(std::vector<double>(entries, 1.0));
        EXPECT_EQ(distribution.bytes(), DiscreteDistribution::bytes_for(entries));
    }
}

}  // namespace
}  // namespace photond::discrete_distribution_test

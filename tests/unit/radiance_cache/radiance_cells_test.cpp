// The table of the radiance cache: means that neither order nor rounding changes, and what becomes of it when it is
// full.

#include "renderer/methods/radiance_cache/radiance_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "renderer/core/rng.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::radiance_cells_test {
namespace {

using Lists = std::vector<std::vector<CellSample>>;

/// Samples of `keys` cells, a hundred lists.
Lists random_samples(uint32_t keys, uint32_t samples, uint32_t seed) {
    RandomStream numbers(seed, RandomDomain::Test, 0, 0);
    Lists lists(100);
    for (uint32_t i = 0; i < samples; ++i) {
        const uint32_t cell = std::min(static_cast<uint32_t>(numbers.next() * static_cast<float>(keys)), keys - 1);
        const Rgb radiance(numbers.next(), 3 * numbers.next(), 1e-3f * numbers.next());
        lists[i % 100].push_back({{hash32(cell), hash32(cell + 77) | 1u}, radiance, numbers.next_bits()});
    }
    return lists;
}

struct Exact {
    dvec3 sum{0};
    uint32_t samples = 0;
    CellKey key{};
};
std::map<uint32_t, Exact> exact_of(const Lists& lists) {
    std::map<uint32_t, Exact> cells;
    for (const auto& list : lists)
        for (const CellSample& sample : list) {
            Exact& cell = cells[sample.key.fingerprint];
            cell.sum += dvec3(sample.radiance);
            cell.key = sample.key;
            ++cell.samples;
        }
    return cells;
}

TEST(RadianceCells, KeepTheMeanOfTheirSamples) {
    const Lists lists = random_samples(500, 20'000, 1);
    RadianceCells cells(1 << 12);
    cells.add(lists);
    EXPECT_EQ(cells.refused(), 0u);
    EXPECT_EQ(cells.cells(), exact_of(lists).size());
    // A channel of n samples is off by less than its rounding: n numbers of a variance of at most a quarter of a unit.
    const double z = test::two_sided_z(test::share_of_false_alarm(1e-6, 1500));
    for (const auto& [fingerprint, exact] : exact_of(lists)) {
        const RadianceCells::Mean mean = cells.find(exact.key);
        ASSERT_EQ(mean.samples, exact.samples);
        for (int c = 0; c < 3; ++c) {
            const double wanted = exact.sum[c] / exact.samples;
            EXPECT_NEAR(mean.radiance[c], wanted, z * 0.5 * cells.unit() / std::sqrt(exact.samples) + 1e-6 * wanted);
        }
    }
    EXPECT_EQ(cells.find({1, 2}).samples, 0u) << "nobody has been there";
}

// More keys than there is room for: what stays, and its sums, are the same whoever comes first.
TEST(RadianceCells, DoNotDependOnTheOrderOrOnTheThreads) {
    const Lists first = random_samples(3000, 10'000, 1);
    const auto contents = [&](int threads, bool reversed) {
        Lists second = random_samples(3000, 10'000, 2);
        if (reversed) {
            std::reverse(second.begin(), second.end());
            for (auto& list : second) std::reverse(list.begin(), list.end());
        }
        return test::on_threads(threads, [&] {
            RadianceCells cells(1 << 10);
            cells.add(first);
            cells.add(second);
            std::vector<float> found{static_cast<float>(cells.refused()), static_cast<float>(cells.cells())};
            for (const auto& [fingerprint, exact] : exact_of(first)) {
                const RadianceCells::Mean mean = cells.find(exact.key);
                found.push_back(static_cast<float>(mean.samples));
                for (int c = 0; c < 3; ++c) found.push_back(mean.radiance[c]);
            }
            return found;
        });
    };
    const std::vector<float> one = contents(1, false);
    EXPECT_GT(one[0], 0) << "the table was to be too small";
    for (const int threads : {1, 2, 8})
        for (const bool reversed : {false, true}) EXPECT_EQ(one, contents(threads, reversed)) << threads;
}

// Truncated, a value of less than a unit would be nothing at all. 10,000 updates, one a round.
TEST(RadianceCells, TenThousandUpdatesDoNotDrift) {
    constexpr uint32_t kUpdates = 10'000;
    const CellKey bright{1, 11}, dim{2, 22};
    const Rgb value(0.37f, 1.9f, 12.5f);
    RadianceCells cells(64);
    RandomStream numbers(3, RandomDomain::Test, 0, 0);
    const float mean_of_first = (value.x + value.y + value.z) / 3;
    const float dim_value = 0.3f * mean_of_first * 0x1p-20f;  // of a unit, or little else
    cells.add(Lists{{{bright, value, numbers.next_bits()}}});
    for (uint32_t i = 1; i < kUpdates; ++i)
        cells.add(Lists{{{bright, value, numbers.next_bits()}, {dim, Rgb(dim_value), numbers.next_bits()}}});
    const RadianceCells::Mean mean = cells.find(bright), dim_mean = cells.find(dim);
    EXPECT_EQ(mean.samples, kUpdates);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean.radiance[c] / value[c], 1, 1e-6) << "1e-4 was asked for";
    const double share = dim_value / cells.unit(), n = kUpdates - 1.0;
    ASSERT_LT(share, 1);
    const double z = test::two_sided_z(test::share_of_false_alarm(1e-6, 3));
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(dim_mean.radiance[c] / cells.unit(), share, z * std::sqrt(share * (1 - share) / n));
}

TEST(RadianceCells, AFullBucketRefusesAndForgetsTheOldest) {
    RadianceCells cells(RadianceCells::kLeastCells);
    const auto sample = [](uint32_t cell, float radiance) { return CellSample{{0, cell}, Rgb(radiance), 1u << 31}; };
    Lists twelve(1);
    for (uint32_t cell = 1; cell <= 12; ++cell) twelve[0].push_back(sample(cell, static_cast<float>(cell)));
    cells.add(twelve);
    EXPECT_EQ(cells.cells(), RadianceCells::kSlots);
    EXPECT_EQ(cells.refused(), 4u);
    for (uint32_t cell = 1; cell <= 12; ++cell) {
        const RadianceCells::Mean mean = cells.find({0, cell});
        EXPECT_EQ(mean.samples, cell > 4 ? 1u : 0u) << cell;
        EXPECT_NEAR(mean.radiance.x, cell > 4 ? static_cast<float>(cell) : 0, 1e-4f * static_cast<float>(cell));
    }
    // As long as all have samples none goes.
    for (uint32_t round = 0; round < 2 * RadianceCells::kMostAge; ++round) cells.add(twelve);
    EXPECT_EQ(cells.evicted(), 0u);
    // Two have none: others take their places, and nobody's sums are mixed up.
    Lists changed(1);
    for (uint32_t cell = 5; cell <= 12; ++cell)
        if (cell != 6 && cell != 11) changed[0].push_back(sample(cell, static_cast<float>(cell)));
    changed[0].push_back(sample(40, 0.25f));
    changed[0].push_back(sample(41, 0.75f));
    for (uint32_t round = 0; round < RadianceCells::kMostAge; ++round) cells.add(changed);
    EXPECT_EQ(cells.find({0, 40}).samples, 0u);
    cells.add(changed);
    EXPECT_EQ(cells.evicted(), 2u);
    EXPECT_EQ(cells.find({0, 6}).samples, 0u);
    EXPECT_EQ(cells.find({0, 11}).samples, 0u);
    EXPECT_NEAR(cells.find({0, 40}).radiance.x, 0.25f, 1e-4f);
    EXPECT_NEAR(cells.find({0, 41}).radiance.x, 0.75f, 1e-4f);
    for (const uint32_t cell : {5u, 7u, 8u, 9u, 10u, 12u})
        EXPECT_NEAR(cells.find({0, cell}).radiance.x, static_cast<float>(cell), 1e-4f * static_cast<float>(cell));
}

TEST(RadianceCells, BlackAndHugeSamplesAreCounted) {
    RadianceCells cells(64);
    cells.add(Lists{{{{1, 1}, Rgb(0), 5}, {{1, 2}, Rgb(0), 6}}});
    EXPECT_EQ(cells.find({1, 1}).samples, 1u);
    EXPECT_EQ(cells.find({1, 1}).radiance, Rgb(0));
    cells.add(Lists{{{{1, 3}, Rgb(2), 7}}});  // the first that is not black says what a unit is
    EXPECT_NEAR(cells.find({1, 3}).radiance.y, 2, 1e-5);
    cells.add(Lists{{{{1, 4}, Rgb(1e30f), 8}}});
    const RadianceCells::Mean huge = cells.find({1, 4});
    EXPECT_NEAR(huge.radiance.x / (2 * 0x1p20), 1, 1e-5) << "as much as a sample counts at most";
    cells.clear();
    EXPECT_EQ(cells.cells(), 0u);
    EXPECT_EQ(cells.find({1, 3}).samples, 0u);
}

}  // namespace
}  // namespace photond::radiance_cells_test

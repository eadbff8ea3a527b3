// The statistical tests decide by these numbers: held against published quantiles.

#include "tests/support/statistics.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"

namespace photond::test::statistics_test {
namespace {

TEST(Statistics, QuantilesMatchTables) {
    EXPECT_NEAR(two_sided_z(0.05), 1.959964, 1e-6);
    EXPECT_NEAR(two_sided_t(0.05, 10), 2.228139, 1e-6);
    EXPECT_NEAR(two_sided_t(0.001, 3), 12.923979, 1e-5);
    EXPECT_NEAR(two_sided_t(0.01, 120), 2.617421, 1e-5);
    EXPECT_NEAR(chi_square_tail(18.307, 10), 0.05, 1e-5);
    EXPECT_NEAR(chi_square_tail(149.449, 100), 0.001, 1e-6);
    EXPECT_NEAR(share_of_false_alarm(0.05, 1), 0.05, 1e-15);
}

TEST(Statistics, DegreesOfADifferenceAreWelchs) {
    RunningMean a, b, exact;
    for (int i = 0; i < 8; ++i) a.add(i), b.add(7 - i), exact.add(1 + 1e-9 * i);
    EXPECT_NEAR(degrees_of_difference(a, b), 14, 1e-12) << "those of both where they are alike";
    EXPECT_NEAR(degrees_of_difference(a, exact), 7, 1e-6) << "of the one alone that is uncertain";
}

TEST(Statistics, IntervalsHoldTheTrueMeanAsOftenAsTheySay) {
    // Four sums of twelve uniform numbers: nearly normal, few enough that Student's t differs from z (3.18
    // against 1.96, which would be wrong in 14 %). 4000 trials at 5 %: standard deviation 0.34 %.
    const std::vector<double> outside = replicates(4000, [](uint64_t seed) {
        RandomStream random(1, RandomDomain::Test, 0, seed);
        const std::vector<double> draws = replicates(4, [&](uint64_t) {
            double sum = 0;
            for (int i = 0; i < 12; ++i) sum += random.next();
            return sum / 12;
        });
        const Interval interval = mean_interval(draws, 0.05, 1);
        return std::fabs(interval.mean - 0.5) > interval.half_width ? 1.0 : 0.0;
    });
    RunningMean rate;
    for (const double x : outside) rate.add(x);
    EXPECT_NEAR(rate.mean(), 0.05, 0.02);
}

TEST(Statistics, StoppingWhenTheIntervalIsNarrowRaisesNoFalseAlarms) {
    // Looked at up to six times at 5 % each without a share, the mean would be outside in some 15 %.
    RunningMean rate, used;
    for (uint64_t trial = 0; trial < 4000; ++trial) {
        RandomStream random(1, RandomDomain::Test, 1, trial);
        size_t drawn = 0;
        const Interval interval = interval_when_narrow(0.4, 24, 0.05, 1, [&](uint64_t) {
            ++drawn;
            double sum = 0;
            for (int i = 0; i < 12; ++i) sum += random.next();
            return sum - 6;  // nearly normal, of variance 1
        });
        rate.add(std::fabs(interval.mean) > interval.half_width ? 1 : 0);
        used.add(static_cast<double>(drawn));
    }
    EXPECT_LE(rate.mean(), 0.05 + 0.017);  // five standard deviations of 4000 trials: fails by chance in 3e-7
    EXPECT_GT(rate.mean(), 0) << "a test that cannot fail";

    RandomStream random(1, RandomDomain::Test, 2, 0);
    size_t drawn = 0;
    const Interval narrow = interval_when_narrow(0.4, 24, 0.05, 1, [&](uint64_t) {
        ++drawn;
        return 1e-3 * random.next();
    });
    EXPECT_EQ(drawn, 4U) << "what is known well enough is not asked again";
    EXPECT_LE(narrow.half_width, 0.4);
}

}  // namespace
}  // namespace photond::test::statistics_test

#include "renderer/error/curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include "renderer/error/estimate.h"
#include "tests/support/statistics.h"

namespace photond::curve_test {
namespace {

TEST(CurveSchedule, MarksPowersOfTwoAndDoublingTimes) {
    // Passes of 0.03 s: pass marks 1, 2, 4, 8, 16; time marks 0.1 (pass 4, 0.12 s), 0.2 (pass 7, 0.21 s), 0.4 (pass
    // 14).
    CurveSchedule schedule;
    std::vector<uint32_t> points;
    for (uint32_t pass = 1; pass <= 20; ++pass)
        if (schedule.due(pass, 0.03 * pass)) points.push_back(pass);
    EXPECT_EQ(points, (std::vector<uint32_t>{1, 2, 4, 7, 8, 14, 16}));
}

TEST(CurveSchedule, SeveralMarksPassedAtOnceAreOnePoint) {
    CurveSchedule schedule;
    EXPECT_TRUE(schedule.due(1, 7.0));     // passes 1; 0.1 ... 6.4 s
    EXPECT_TRUE(schedule.due(2, 7.1));     // passes 2
    EXPECT_FALSE(schedule.due(3, 12.79));  // next are 4 and 12.8 s
    EXPECT_TRUE(schedule.due(11, 12.79));  // passes 4 and 8
    EXPECT_FALSE(schedule.due(12, 12.79));
    EXPECT_TRUE(schedule.due(13, 12.8));  // "at or after"
    EXPECT_FALSE(schedule.due(15, 25.59));
    EXPECT_TRUE(schedule.due(16, 25.6));  // both at once
    EXPECT_FALSE(schedule.due(17, 25.6));
    EXPECT_TRUE(schedule.due(std::numeric_limits<uint32_t>::max(), 25.6));
    EXPECT_FALSE(schedule.due(std::numeric_limits<uint32_t>::max(), 25.6));  // 2^32 is not reached
}

TEST(CurveSchedule, SkippingIsAsIfAsked) {
    for (const auto& [passes, seconds] : {std::pair(0u, 0.0), std::pair(5u, 0.05), std::pair(6u, 3.3)}) {
        CurveSchedule asked, skipped;
        asked.due(passes, seconds);
        skipped.skip_to(passes, seconds);
        for (uint32_t pass = passes + 1; pass < 70; ++pass)
            EXPECT_EQ(asked.due(pass, seconds + 0.1 * pass), skipped.due(pass, seconds + 0.1 * pass)) << pass;
    }
    CurveSchedule schedule;
    schedule.skip_to(5, 0.05);
    EXPECT_FALSE(schedule.due(6, 0.06));
    EXPECT_TRUE(schedule.due(8, 0.08));
    EXPECT_TRUE(schedule.due(9, 0.1));
}

CurvePoint point(double seconds, std::optional<double> value) {
    CurvePoint result{.seconds = seconds, .passes = 1, .photons = {}, .metrics = {}};
    result.metrics["rmse"] = value;
    return result;
}

TEST(TimedErrors, KeepsWhatHasAValue) {
    std::vector<CurvePoint> curve{point(0.5, 4), point(1, std::nullopt), point(2, 0), point(3, 2), point(3, 1.5)};
    curve.push_back({.seconds = 4, .passes = 9, .photons = {}, .metrics = {{"mae", 1.0}}});
    curve.push_back(point(5, 1));
    curve.push_back(point(6, std::numeric_limits<double>::infinity()));
    curve.insert(curve.begin(), point(0, 8));  // before the clock had moved
    const std::vector<TimedError> errors = timed_errors(curve, "rmse");
    ASSERT_EQ(errors.size(), 4u);
    EXPECT_EQ(errors[0].seconds, 0.5);
    EXPECT_EQ(errors[1].error, 0);
    EXPECT_EQ(errors[2].seconds, 3);
    EXPECT_EQ(errors[2].error, 1.5);  // two points at one time: the later
    EXPECT_EQ(errors[3].error, 1);
    EXPECT_TRUE(timed_errors(curve, "smape").empty());
}

TEST(TimedErrors, KeepsWhatIsEstimatedBelowZero) {
    std::vector<CurvePoint> curve{point(1, 0.5), point(2, -0.1), point(3, std::nullopt), point(4, std::nullopt)};
    curve[0].intervals["rmse"] = {0.4, 0.6};
    curve[1].intervals["rmse"] = {-0.3, 0.1};
    curve[2].intervals["rmse"] = {0, 0.2};  // the root of what lies below 0
    curve[3].intervals["rmse"] = {0, 0};    // of what all of the interval lies below
    const std::vector<TimedError> errors = timed_errors(curve, "rmse");
    ASSERT_EQ(errors.size(), 3u);
    EXPECT_EQ(errors[0].interval, (Interval{0.4, 0.6}));
    EXPECT_EQ(errors[1].error, -0.1);
    EXPECT_EQ(errors[2].error, 0);
    EXPECT_EQ(errors[0].upper_end(), 0.6);
    EXPECT_EQ(errors[1].upper_end(), 0.2) << "half of the width: what an error of 0 would have";
    EXPECT_EQ(errors[2].upper_end(), 0.2);
    EXPECT_EQ((TimedError{1, -3, Interval{-4, -2}}).upper_end(), 1) << "never below 0, however lucky";
    EXPECT_EQ((TimedError{1, 0.3}).upper_end(), 0.3);
}

TEST(NonIncreasingFit, IsTheBestOfAllNonIncreasingSequences) {
    EXPECT_TRUE(non_increasing_fit({}).empty());
    EXPECT_EQ(non_increasing_fit(std::vector{3.0, 1.0, 2.0, 3.0, 0.0}), (std::vector{3.0, 2.0, 2.0, 2.0, 0.0}));
    // By the min-max formula [Barlow et al. 1972, Eq. 1.9]: max over b >= i of min over a <= i of the mean of a ... b.
    std::mt19937 random(5);
    for (int run = 0; run < 200; ++run) {
        std::vector<double> values(1 + random() % 9);
        for (double& value : values) value = static_cast<double>(random() % 8);
        const std::vector<double> fit = non_increasing_fit(values);
        ASSERT_EQ(fit.size(), values.size());
        for (size_t i = 0; i < values.size(); ++i) {
            double best = -1;
            for (size_t b = i; b < values.size(); ++b) {
                double least = 100;
                for (size_t a = 0; a <= i; ++a)
                    least = std::min(least, std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(a),
                                                            values.begin() + static_cast<std::ptrdiff_t>(b) + 1, 0.0) /
                                                static_cast<double>(b - a + 1));
                best = std::max(best, least);
            }
            EXPECT_NEAR(fit[i], best, 1e-12);
        }
    }
}

/// error = 3 t^-0.7 at t = 0.1, 0.2, 0.4 ...
std::vector<TimedError> power_law(size_t count) {
    std::vector<TimedError> curve;
    for (double t = 0.1; curve.size() < count; t *= 2) curve.push_back({t, 3 * std::pow(t, -0.7)});
    return curve;
}

TEST(TimeToError, PowerLawsInterpolateExactly) {
    const std::vector<TimedError> curve = power_law(10);  // to 51.2 s
    for (double t = 0.1; t < 25; t *= 1.07) {
        const double error = 3 * std::pow(t, -0.7);
        EXPECT_NEAR(*time_to_error(curve, error) / t, 1, 1e-12) << t;
        EXPECT_NEAR(error_at_time(curve, t)->error / error, 1, 1e-12) << t;
        EXPECT_FALSE(earliest_time_to_error(curve, error)) << "nothing is known of its noise";
    }
    for (const TimedError& point : std::span(curve).first(9)) {
        EXPECT_EQ(*time_to_error(curve, point.error), point.seconds);
        EXPECT_EQ(error_at_time(curve, point.seconds)->error, point.error);
    }
    EXPECT_FALSE(time_to_error(curve, curve.back().error)) << "no other point bears the last one out";
    EXPECT_EQ(errors_reached(curve), (Interval{curve[8].error, curve[0].error}));
}

TEST(TimeToError, AfterTwoPointsOffAFallingFit) {
    // A point and the next are both at most 4, 4, 4, 1.5: down through 2 between 4 s and 8 s, as log error falls from
    // log 4 to log 1.5.
    const std::vector<TimedError> curve{{1, 4}, {2, 1}, {4, 4}, {8, 1}, {16, 1.5}};
    EXPECT_NEAR(*time_to_error(curve, 2), 4 * std::pow(2, std::log(2) / std::log(4 / 1.5)), 1e-12);
    EXPECT_EQ(*time_to_error(curve, 1.5), 8.0);
    EXPECT_FALSE(time_to_error(curve, 1.25));  // was reached, but never twice
    EXPECT_FALSE(time_to_error(curve, 0.5));
    EXPECT_FALSE(time_to_error(curve, 0));
    EXPECT_EQ(*time_to_error(curve, 4), 1.0);  // from the first point on
    EXPECT_EQ(*time_to_error(curve, 9), 1.0);
    EXPECT_FALSE(time_to_error({}, 1));
    EXPECT_FALSE(time_to_error(std::vector<TimedError>{{1, 0.5}}, 1)) << "one point alone";
    // At most 8, 2, 2, 9, 9, 1: a rise draws up what was there before, 2, 2, 9 and 9 to (4 x 81)^(1/4).
    const std::vector<TimedError> risen{{1, 8}, {2, 2}, {4, 2}, {8, 2}, {16, 9}, {32, 1}, {64, 1}};
    const double fit = std::pow(4 * 81, 0.25);
    EXPECT_NEAR(*time_to_error(risen, 5), std::pow(2, std::log(8 / 5.0) / std::log(8 / fit)), 1e-12);
    EXPECT_NEAR(*time_to_error(risen, 2), 16 * std::pow(2, std::log(fit / 2) / std::log(fit)), 1e-12);
}

TEST(TimeToError, ZeroIsBelowEveryErrorAndDrawsNothingDown) {
    const std::vector<TimedError> fireflies{{1, 9}, {2, 3}, {4, 0}, {8, 0}, {16, 0}};
    EXPECT_EQ(*time_to_error(fireflies, 3), 2.0);
    EXPECT_NEAR(*time_to_error(fireflies, 1), 4, 1e-12);
    EXPECT_EQ(errors_reached(fireflies), (Interval{3, 9}));
    EXPECT_EQ(*time_to_error(std::vector<TimedError>{{1, 0}, {2, 0}}, 1e-9), 1.0);
    EXPECT_FALSE(errors_reached(std::vector<TimedError>{{1, 0}, {2, 0}}));
    // Two that vanish and return: with 2, the smallest, in their place 2, 2, 8, 8 come to 4.
    const std::vector<TimedError> back{{1, 64}, {2, 0}, {4, 0}, {8, 0}, {16, 8}, {32, 2}, {64, 2}};
    EXPECT_NEAR(*time_to_error(back, 4), 2, 1e-12);
    EXPECT_NEAR(*time_to_error(back, 2), 32, 1e-12);
}

TEST(TimeToError, IsReadFromTheUpperEndsAndTheEarliestFromTheLower) {
    // Errors 8 / t, known to a factor of 2; then what may be 0.
    std::vector<TimedError> curve;
    for (double t = 1; t <= 16; t *= 2) curve.push_back({t, 8 / t, Interval{4 / t, 16 / t}});
    EXPECT_NEAR(*time_to_error(curve, 4), 4, 1e-12);
    EXPECT_NEAR(*earliest_time_to_error(curve, 4), 1, 1e-12);
    EXPECT_NEAR(*earliest_time_to_error(curve, 1), 4, 1e-12);
    EXPECT_FALSE(time_to_error(curve, 1));
    curve.push_back({32, 0.1, Interval{-0.5, 0.7}});
    curve.push_back({64, -0.4, Interval{-0.8, 0.0}});
    EXPECT_NEAR(*time_to_error(curve, 1), 16, 1e-12);
    EXPECT_EQ(*earliest_time_to_error(curve, 0.1), 16.0) << "somewhere after 16 s its lower end has gone below 0";
    EXPECT_FALSE(time_to_error(curve, 0.69)) << "the last is at most 0.4, but alone";
    curve.push_back({128, -0.4, Interval{-0.8, 0.0}});
    EXPECT_EQ(errors_reached(curve)->least, 0.4) << "what lies below 0 is half of its width";
    curve[2].interval.reset();
    EXPECT_FALSE(earliest_time_to_error(curve, 4)) << "of one point it is not known";
}

// --- References' noise --------------------------------------------------------------------------------------------

/// Errors 1 / n of films of n = 1, 2, 4 ... passes, measured against two references of this variance each: what is
/// measured is off by mean (U - I)(V - I), the same at all n, and by the mean of (A - I) times both, which follows the
/// film: its sum over passes is a random walk. Pixels are many, so that both are normal and their variance is known.
struct Measuring {
    static constexpr int kPoints = 13;
    static constexpr double kPixels = 4096;
    double reference_variance = 0;

    double standard_error(double passes) const {
        return std::sqrt((reference_variance * reference_variance + 2 * reference_variance / passes) / kPixels);
    }
    std::vector<TimedError> without_noise() const {
        std::vector<TimedError> curve;
        for (int k = 0; k < kPoints; ++k) curve.push_back(measured(std::exp2(k), 0));
        return curve;
    }
    std::vector<TimedError> curve(std::mt19937_64& random) const {
        std::normal_distribution<double> normal;
        const double shared = reference_variance / std::sqrt(kPixels) * normal(random);
        std::vector<TimedError> curve;
        double walk = 0, before = 0;
        for (int k = 0; k < kPoints; ++k) {
            const double passes = std::exp2(k);
            walk += std::sqrt(2 * reference_variance / kPixels * (passes - before)) * normal(random);
            before = passes;
            curve.push_back(measured(passes, shared + walk / passes));
        }
        return curve;
    }

private:
    TimedError measured(double passes, double noise) const {
        const double error = 1 / passes + noise, half = kConfidenceZ * standard_error(passes);
        return {passes, error, Interval{error - half, error + half}};
    }
};

/// P(X > z), X normal.
double upper_tail(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

/// The rule's own rate (time_to_error()): how often a time is too early by a factor, at most.
double too_early(double factor) {
    double sum = 0;
    for (int m = 0; m < 8; ++m) sum += 2 * upper_tail(kConfidenceZ * factor * std::exp2(m));
    return sum;
}

constexpr int kCurves = 1000;
constexpr double kAlarm = 1e-6 / 200;  // false alarms are shared by fewer than 200 checks

/// The count that kCurves draws of this chance exceed with a chance of kAlarm at most.
int most_of(double chance) {
    double log_term = kCurves * std::log1p(-chance), tail = 1;
    for (int count = 0;; ++count) {
        tail -= std::exp(log_term);
        if (tail <= kAlarm) return count;
        log_term += std::log((kCurves - count) / (count + 1.0) * chance / (1 - chance));
    }
}

TEST(ReferenceNoise, NoTimeIsTooEarlyMoreOftenThanStated) {
    ASSERT_NEAR(too_early(1), 0.101, 5e-4);
    ASSERT_NEAR(too_early(2), 0.001, 5e-5);
    std::mt19937_64 random(22);
    // Half of an interval's width in the end over the error in the end: 0.15, 11 and 1100.
    for (const double variance : {1e-3, 0.1, 10.0}) {
        const Measuring measuring{variance};
        std::vector<std::vector<TimedError>> curves;
        for (int i = 0; i < kCurves; ++i) curves.push_back(measuring.curve(random));
        const double last_half = kConfidenceZ * measuring.standard_error(std::exp2(Measuring::kPoints - 1));
        const std::vector<TimedError> expected = measuring.without_noise();
        for (double error = 0.7; error > 2e-4; error /= 3) {
            SCOPED_TRACE(testing::Message() << "references of variance " << variance << ", error " << error);
            const double truth = 1 / error;
            int early = 0, early_twice = 0, by_value_early = 0, never = 0;
            std::vector<double> times;
            for (const auto& curve : curves) {
                const auto time = time_to_error(curve, error);
                early += time && *time < truth;
                early_twice += time && *time < truth / 2;
                never += !time;
                times.push_back(time.value_or(1e9));
                EXPECT_LE(earliest_time_to_error(curve, error).value_or(0), time.value_or(1e9));
                const auto by_value = std::find_if(curve.begin(), curve.end(),
                                                   [&](const TimedError& point) { return point.error <= error; });
                by_value_early += by_value != curve.end() && by_value->seconds < truth;
            }
            EXPECT_LE(early, most_of(too_early(1)));
            EXPECT_LE(early_twice, most_of(too_early(2)));
            if (error < last_half) {
                EXPECT_EQ(never, kCurves) << "no reference shows less than its own noise leaves open";
                EXPECT_GT(by_value_early, kCurves / 4) << "which values alone do, by luck";
            }
            // How far off: upper ends are too large by z standard errors, noise falls to either side of that. So half
            // of the times are to either side of the one without noise, as far as a fit hardly moves it.
            const auto middle = time_to_error(expected, error);
            if (middle && last_half < error / 3) {
                std::sort(times.begin(), times.end());
                const int spread = most_of(0.5) - kCurves / 2;
                EXPECT_LE(times[static_cast<size_t>(kCurves / 2 - spread)], *middle * (1 + 1e-9));
                EXPECT_GE(times[static_cast<size_t>(kCurves / 2 + spread)], *middle * (1 - 1e-9));
            }
        }
    }
}

TEST(ReferenceNoise, TimesAreReadOnceTheIntervalIsBelow) {
    // Where an error and twice what its upper end adds are below a level, that point is not too late: it is where noise
    // exceeds z standard errors, or a later point's does by as much more as the error has fallen since.
    for (const double variance : {1e-3, 0.1}) {
        const Measuring measuring{variance};
        std::mt19937_64 random(23);
        int levels = 0;
        for (double error = 0.7; error > 2e-4; error /= 3) {
            int k = 0;
            const auto is_below = [&](double passes) {
                return 1 / passes + 2 * kConfidenceZ * measuring.standard_error(passes) <= error;
            };
            while (k + 1 < Measuring::kPoints && !is_below(std::exp2(k))) ++k;
            if (k + 1 == Measuring::kPoints) continue;
            double chance = 0;
            for (int m = 0; k + m < Measuring::kPoints; ++m) {
                const double passes = std::exp2(k + m);
                chance += upper_tail((error - 1 / passes) / measuring.standard_error(passes) - kConfidenceZ);
            }
            int late = 0;
            for (int i = 0; i < kCurves; ++i) {
                const auto time = time_to_error(measuring.curve(random), error);
                late += !time || *time > std::exp2(k);
            }
            ASSERT_LT(chance, 0.3) << "or this says nothing";
            EXPECT_LE(late, most_of(chance)) << "references of variance " << variance << ", error " << error;
            ++levels;
        }
        EXPECT_GE(levels, variance < 0.01 ? 6 : 3);
    }
}

TEST(ErrorAtTime, IsEmptyOutsideTheCurve) {
    const std::vector<TimedError> curve = power_law(3);
    EXPECT_FALSE(error_at_time(curve, 0.0999));
    EXPECT_FALSE(error_at_time(curve, 0.4001));
    EXPECT_FALSE(error_at_time({}, 1));
    const std::vector<TimedError> one{{2, 5}};
    EXPECT_EQ(error_at_time(one, 2)->error, 5);
    EXPECT_FALSE(error_at_time(one, 3));
}

TEST(ErrorAtTime, LiesBetweenItsNeighboursWithItsInterval) {
    // Half-way in log time: the geometric mean, and the means of what the ends lie off.
    const std::vector<TimedError> curve{{1, 16, Interval{12, 18}}, {4, 1, Interval{-1, 5}}, {16, -3, Interval{-9, 3}}};
    const TimedError first = *error_at_time(curve, 2);
    EXPECT_NEAR(first.error, 4, 1e-12);
    EXPECT_NEAR(first.interval->least, 4 - 3, 1e-12);
    EXPECT_NEAR(first.interval->greatest, 4 + 3, 1e-12);
    const TimedError second = *error_at_time(curve, 8);  // linear: -3 has no logarithm
    EXPECT_NEAR(second.error, -1, 1e-12);
    EXPECT_NEAR(second.interval->least, -1 - 4, 1e-12);
    EXPECT_NEAR(second.interval->greatest, -1 + 5, 1e-12);
}

TEST(ArithmeticMean, MatchesIntervalsWorkedByHand) {
    // -1, 0 and 4: mean 1, deviation sqrt 7; t(0.975, 2) = 4.30265273.
    const SeedMean three = *arithmetic_mean(std::vector{-1.0, 0.0, 4.0});
    EXPECT_NEAR(three.mean, 1, 1e-14);
    EXPECT_NEAR(*three.low, 1 - 4.30265273 * std::sqrt(7.0 / 3), 1e-7);
    EXPECT_NEAR(*three.high, 1 + 4.30265273 * std::sqrt(7.0 / 3), 1e-7);
    EXPECT_FALSE(arithmetic_mean({}));
    EXPECT_FALSE(arithmetic_mean(std::vector{1.0, std::numeric_limits<double>::quiet_NaN()}));
    EXPECT_FALSE(arithmetic_mean(std::vector{-2.0})->low);
}

TEST(LogMean, MatchesIntervalsWorkedByHand) {
    const double e = std::numbers::e;
    // Logarithms 0 and 2: mean 1, deviation sqrt 2, standard error 1; t(0.975, 1) = 12.70620474.
    const SeedMean two = *log_mean(std::vector{1.0, e * e});
    EXPECT_NEAR(two.mean, e, 1e-14);
    EXPECT_NEAR(std::log(*two.high), 1 + 12.70620474, 1e-7);
    EXPECT_NEAR(std::log(*two.low), 1 - 12.70620474, 1e-7);
    // Logarithms 0, 1 and 2: mean 1, deviation 1, standard error 1/sqrt 3; t(0.975, 2) = 4.30265273.
    const SeedMean three = *log_mean(std::vector{e * e, 1.0, e});
    EXPECT_NEAR(std::log(*three.high), 1 + 4.30265273 / std::sqrt(3), 1e-8);
    EXPECT_NEAR(std::log(*three.low), 1 - 4.30265273 / std::sqrt(3), 1e-8);
}

TEST(LogMean, AgreesWithTheTestsOwnStudentT) {
    // Which goes by the incomplete beta function; ours is a finite sum. n values with logarithms +-1.
    for (size_t n = 2; n <= 400; n += n < 40 ? 1 : 45) {
        std::vector<double> values;
        for (size_t i = 0; i < n; ++i) values.push_back(std::exp(i % 2 == 0 ? 1 : -1));
        const SeedMean result = *log_mean(values);
        test::RunningMean logs;
        for (const double value : values) logs.add(std::log(value));
        const double t = test::two_sided_t(0.05, static_cast<double>(n) - 1);
        EXPECT_NEAR(std::log(*result.high / result.mean) / (t * logs.standard_error()), 1, 1e-9) << n;
        EXPECT_NEAR(std::log(result.mean / *result.low) / (t * logs.standard_error()), 1, 1e-9) << n;
    }
}

TEST(LogMean, OfFewOrUnusableNumbers) {
    EXPECT_FALSE(log_mean({}));
    const SeedMean one = *log_mean(std::vector{5.0});
    EXPECT_NEAR(one.mean, 5, 1e-14);
    EXPECT_FALSE(one.low);
    EXPECT_FALSE(one.high);
    EXPECT_FALSE(log_mean(std::vector{1.0, 0.0}));
    EXPECT_FALSE(log_mean(std::vector{1.0, -1.0}));
    EXPECT_FALSE(log_mean(std::vector{1.0, std::numeric_limits<double>::infinity()}));
    const SeedMean same = *log_mean(std::vector{2.0, 2.0, 2.0});
    EXPECT_NEAR(*same.low, 2, 1e-14);
    EXPECT_NEAR(*same.high, 2, 1e-14);
}

TEST(LogLogSlope, IsThePowerAndTheLeastSquares) {
    std::vector<double> x, y;
    for (const TimedError& point : power_law(6)) x.push_back(point.seconds), y.push_back(point.error);
    EXPECT_NEAR(*log_log_slope(x, y), -0.7, 1e-13);
    // Log x = 0, 1, 2 and log y = 0, 0, 3 (in any base): slope sum((x - 1)(y - 1)) / sum((x - 1)^2) = (1 + 2) / 2.
    EXPECT_NEAR(*log_log_slope(std::vector{1.0, 10.0, 100.0}, std::vector{1.0, 1.0, 1000.0}), 1.5, 1e-13);
    EXPECT_FALSE(log_log_slope({}, {}));
    EXPECT_FALSE(log_log_slope(std::vector{1.0}, std::vector{1.0}));
    EXPECT_FALSE(log_log_slope(std::vector{3.0, 3.0, 3.0}, std::vector{1.0, 2.0, 5.0}));
    EXPECT_FALSE(log_log_slope(std::vector{1.0, 2.0}, std::vector{1.0, 0.0}));
}

}  // namespace
}  // namespace photond::curve_test

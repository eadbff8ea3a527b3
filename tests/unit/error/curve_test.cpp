#include "renderer/error/curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

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

TEST(TimedErrors, KeepsWhatALogarithmHas) {
    std::vector<CurvePoint> curve{point(0.5, 4), point(1, std::nullopt), point(2, 0), point(3, 2), point(3, 1.5)};
    curve.push_back({.seconds = 4, .passes = 9, .photons = {}, .metrics = {{"mae", 1.0}}});
    curve.push_back(point(5, 1));
    curve.insert(curve.begin(), point(0, 8));  // before the clock had moved
    const std::vector<TimedError> errors = timed_errors(curve, "rmse");
    ASSERT_EQ(errors.size(), 3u);
    EXPECT_EQ(errors[0].seconds, 0.5);
    EXPECT_EQ(errors[1].seconds, 3);
    EXPECT_EQ(errors[1].error, 1.5);  // two points at one time: the later
    EXPECT_EQ(errors[2].error, 1);
    EXPECT_TRUE(timed_errors(curve, "smape").empty());
}

/// error = 3 t^-0.7 at t = 0.1, 0.2, 0.4 ...
std::vector<TimedError> power_law(size_t count) {
    std::vector<TimedError> curve;
    for (double t = 0.1; curve.size() < count; t *= 2) curve.push_back({t, 3 * std::pow(t, -0.7)});
    return curve;
}

TEST(TimeToError, PowerLawsInterpolateExactly) {
    const std::vector<TimedError> curve = power_law(10);  // to 51.2 s
    for (double t = 0.1; t < 51; t *= 1.07) {
        const double error = 3 * std::pow(t, -0.7);
        EXPECT_NEAR(*time_to_error(curve, error) / t, 1, 1e-12) << t;
        EXPECT_NEAR(*error_at_time(curve, t) / error, 1, 1e-12) << t;
    }
    for (const TimedError& point : curve) {
        EXPECT_EQ(*time_to_error(curve, point.error), point.seconds);
        EXPECT_EQ(*error_at_time(curve, point.seconds), point.error);
    }
}

TEST(TimeToError, AfterTheLastCrossing) {
    // Down through 2 between 1 s and 2 s, up again between 2 s and 4 s, down for good between 4 s and 8 s: there log
    // error falls from log 4 to log 1, and log 2 is half-way: at 4 sqrt 2.
    const std::vector<TimedError> curve{{1, 4}, {2, 1}, {4, 4}, {8, 1}, {16, 1.5}};
    EXPECT_NEAR(*time_to_error(curve, 2), 4 * std::numbers::sqrt2, 1e-12);
    EXPECT_FALSE(time_to_error(curve, 1.25));  // was reached, and is left again
    EXPECT_EQ(*time_to_error(curve, 1.5), 8 * std::pow(0.5, std::log(1.5) / std::log(4)));
    EXPECT_FALSE(time_to_error(curve, 0.5));
    EXPECT_FALSE(time_to_error(curve, 0));
    EXPECT_EQ(*time_to_error(curve, 4), 1.0);  // from the first point on
    EXPECT_EQ(*time_to_error(curve, 9), 1.0);
    EXPECT_FALSE(time_to_error({}, 1));
}

TEST(ErrorAtTime, IsEmptyOutsideTheCurve) {
    const std::vector<TimedError> curve = power_law(3);
    EXPECT_FALSE(error_at_time(curve, 0.0999));
    EXPECT_FALSE(error_at_time(curve, 0.4001));
    EXPECT_FALSE(error_at_time({}, 1));
    const std::vector<TimedError> one{{2, 5}};
    EXPECT_EQ(*error_at_time(one, 2), 5);
    EXPECT_FALSE(error_at_time(one, 3));
}

TEST(LogMean, MatchesIntervalsWorkedByHand) {
    const double e = std::numbers::e;
    // Logarithms 0 and 2: mean 1, deviation sqrt 2, standard error 1; t(0.975, 1) = 12.70620474.
    const LogMean two = *log_mean(std::vector{1.0, e * e});
    EXPECT_NEAR(two.mean, e, 1e-14);
    EXPECT_NEAR(std::log(*two.high), 1 + 12.70620474, 1e-7);
    EXPECT_NEAR(std::log(*two.low), 1 - 12.70620474, 1e-7);
    // Logarithms 0, 1 and 2: mean 1, deviation 1, standard error 1/sqrt 3; t(0.975, 2) = 4.30265273.
    const LogMean three = *log_mean(std::vector{e * e, 1.0, e});
    EXPECT_NEAR(std::log(*three.high), 1 + 4.30265273 / std::sqrt(3), 1e-8);
    EXPECT_NEAR(std::log(*three.low), 1 - 4.30265273 / std::sqrt(3), 1e-8);
}

TEST(LogMean, AgreesWithTheTestsOwnStudentT) {
    // Which goes by the incomplete beta function; ours is a finite sum. n values with logarithms +-1.
    for (size_t n = 2; n <= 400; n += n < 40 ? 1 : 45) {
        std::vector<double> values;
        for (size_t i = 0; i < n; ++i) values.push_back(std::exp(i % 2 == 0 ? 1 : -1));
        const LogMean result = *log_mean(values);
        test::RunningMean logs;
        for (const double value : values) logs.add(std::log(value));
        const double t = test::two_sided_t(0.05, static_cast<double>(n) - 1);
        EXPECT_NEAR(std::log(*result.high / result.mean) / (t * logs.standard_error()), 1, 1e-9) << n;
        EXPECT_NEAR(std::log(result.mean / *result.low) / (t * logs.standard_error()), 1, 1e-9) << n;
    }
}

TEST(LogMean, OfFewOrUnusableNumbers) {
    EXPECT_FALSE(log_mean({}));
    const LogMean one = *log_mean(std::vector{5.0});
    EXPECT_NEAR(one.mean, 5, 1e-14);
    EXPECT_FALSE(one.low);
    EXPECT_FALSE(one.high);
    EXPECT_FALSE(log_mean(std::vector{1.0, 0.0}));
    EXPECT_FALSE(log_mean(std::vector{1.0, -1.0}));
    EXPECT_FALSE(log_mean(std::vector{1.0, std::numeric_limits<double>::infinity()}));
    const LogMean same = *log_mean(std::vector{2.0, 2.0, 2.0});
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

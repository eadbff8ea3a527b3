// Tables of curves whose answers are known: power laws, error = scale x seconds^-slope, are straight in log-log, so
// that every interpolation between their points is exact.

#include "server/comparisons/table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "server/comparisons/levels.h"
#include "server/comparisons/measured_job.h"
#include "server/comparisons/pareto.h"
#include "server/comparisons/report_csv.h"

namespace photond::comparison_table_test {
namespace {

using nlohmann::json;

MeasuredJob power_law(const std::string& label, uint64_t seed, double scale, double slope, double first_s = 0.1,
                      double last_s = 102.4) {
    MeasuredJob job;
    job.id = label + std::to_string(seed);
    job.label = label;
    job.parameters = json::object();
    job.seed = seed;
    job.state = "succeeded";
    uint32_t passes = 1;
    for (double seconds = first_s; seconds <= last_s; seconds *= 2) {
        const double error = scale * std::pow(seconds, -slope);
        job.curve.push_back({seconds, passes, {}, {{"relative_mse", error}, {"rmse", std::sqrt(error)}}});
        job.passes = passes;
        job.seconds = seconds;
        passes *= 2;
    }
    return job;
}

const TimeToError& level_of(const TableRow& row, double error) {
    for (const TimeToError& level : row.time_to_error.at("relative_mse"))
        if (level.error == error) return level;
    throw std::runtime_error("no level " + std::to_string(error));
}

const ErrorAtTime& time_of(const TableRow& row, double seconds) {
    for (const ErrorAtTime& time : row.error_at_time.at("relative_mse"))
        if (time.seconds == seconds) return time;
    throw std::runtime_error("no time " + std::to_string(seconds));
}

TEST(ComparisonTable, ReadsPowerLawsExactly) {
    const std::vector<MeasuredJob> jobs{power_law("slow", 1, 0.1, 1), power_law("fast", 1, 0.2, 2)};
    const ComparisonTable table = make_table(jobs, {"relative_mse"});
    ASSERT_EQ(table.rows.size(), 2u);
    // error = 0.1 / t and 0.2 / t^2.
    EXPECT_NEAR(level_of(table.rows[0], 0.01).seconds->mean, 10, 1e-9);
    EXPECT_NEAR(level_of(table.rows[1], 0.01).seconds->mean, std::sqrt(20), 1e-9);
    EXPECT_NEAR(time_of(table.rows[0], 5).mean->error.mean, 0.02, 1e-12);
    EXPECT_NEAR(time_of(table.rows[1], 5).mean->error.mean, 0.008, 1e-12);
    EXPECT_FALSE(level_of(table.rows[0], 0.01).seconds->low) << "one seed has no interval";
    // 1 / (mse x seconds) at the end: rmse^2 = 0.1 / 102.4.
    EXPECT_NEAR(*table.rows[0].efficiency, 10, 1e-9);
}

TEST(ComparisonTable, IntervalsAreOfTheSeedsLogarithms) {
    // Times to reach 0.01 are 10 x {1/2, 1, 2}: geometric mean 10, logarithms spread by ln 2.
    const std::vector<MeasuredJob> jobs{power_law("a", 1, 0.05, 1), power_law("a", 2, 0.1, 1),
                                        power_law("a", 3, 0.2, 1)};
    const ComparisonTable table = make_table(jobs, {"relative_mse"});
    ASSERT_EQ(table.rows.size(), 1u);
    const TimeToError& level = level_of(table.rows[0], 0.01);
    EXPECT_EQ(level.reached, 3u);
    EXPECT_NEAR(level.seconds->mean, 10, 1e-9);
    // Student's t, 2 degrees of freedom, two-sided 95 %: 4.302653 [tables].
    const double half_width = 4.302653 * std::log(2.0) / std::sqrt(3.0);
    EXPECT_NEAR(*level.seconds->low, 10 * std::exp(-half_width), 1e-5);
    EXPECT_NEAR(*level.seconds->high, 10 * std::exp(half_width), 1e-4);
    EXPECT_EQ(table.rows[0].jobs, (std::vector<std::string>{"a1", "a2", "a3"}));
}

TEST(ComparisonTable, WhatNotEverySeedReachedIsNull) {
    const std::vector<MeasuredJob> jobs{power_law("a", 1, 0.1, 1), power_law("a", 2, 0.1, 1, 0.1, 1.6),
                                        power_law("b", 1, 0.1, 1), power_law("b", 2, 0.1, 1)};
    const json rows = to_json(make_table(jobs, {"relative_mse"}));
    // After 0.8 s the error is 0.125, and at 1.6 s 0.0625 bears that out: seed 2 of a never sees 0.05, nor 0.1 twice.
    const auto find = [](const json& list, const char* key, double value) {
        for (const json& item : list)
            if (item.at(key) == value) return item;
        throw std::runtime_error("not found");
    };
    const json level = find(rows[0]["time_to_error"]["relative_mse"], "error", 0.05);
    EXPECT_EQ(level,
              json::parse(R"({"error": 0.05, "at_most": false, "reached": 1, "seconds": null, "low": null, "high": null,
                        "earliest": null, "latest": null})"));
    EXPECT_TRUE(find(rows[1]["time_to_error"]["relative_mse"], "error", 0.05)["seconds"].is_number());
    EXPECT_TRUE(find(rows[0]["time_to_error"]["relative_mse"], "error", 0.1)["seconds"].is_null());
    EXPECT_TRUE(find(rows[0]["time_to_error"]["relative_mse"], "error", 0.2)["seconds"].is_number());
    const json time = find(rows[0]["error_at_time"]["relative_mse"], "seconds", 2);
    EXPECT_EQ(time["reached"], 1);
    EXPECT_TRUE(time["error"].is_null());
}

TEST(ComparisonTable, LevelsAreRoundUsefulAndFew) {
    // From 1 (at 0.1 s) down to 0.1 / 51.2, which the point at 102.4 s bears out.
    const std::vector<MeasuredJob> jobs{power_law("a", 1, 0.1, 1)};
    const ComparisonTable table = make_table(jobs, {"relative_mse"});
    std::vector<double> errors, times;
    for (const TimeToError& level : table.rows[0].time_to_error.at("relative_mse")) errors.push_back(level.error);
    for (const ErrorAtTime& time : table.rows[0].error_at_time.at("relative_mse")) times.push_back(time.seconds);
    EXPECT_EQ(errors, (std::vector<double>{1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002}));
    EXPECT_EQ(times, (std::vector<double>{0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100}));
    // The first point is at 0.1 s and has the error 1: when it was reached before is not known; of what came later it
    // is.
    for (const TimeToError& level : table.rows[0].time_to_error.at("relative_mse"))
        EXPECT_EQ(level.at_most, level.error == 1) << level.error;
    // Six decades: the hard end stays, twelve levels, and what was asked for.
    const std::vector<MeasuredJob> deep{power_law("a", 1, 1e-2, 2)};
    const ComparisonTable wished = make_table(deep, {"relative_mse"}, {{{"relative_mse", 0.003}}, 30.0});
    const auto& levels = wished.rows[0].time_to_error.at("relative_mse");
    ASSERT_EQ(levels.size(), 13u);
    EXPECT_EQ(levels.front().error, 0.02);
    EXPECT_EQ(levels[2].error, 0.005);
    EXPECT_EQ(levels[3].error, 0.003);
    EXPECT_EQ(levels.back().error, 5e-6);
    EXPECT_NEAR(time_of(wished.rows[0], 30).mean->error.mean, 1e-2 / 900, 1e-15);
}

TEST(ComparisonTable, StatesTheReferencesNoise) {
    std::vector<MeasuredJob> jobs{power_law("a", 1, 0.1, 1), power_law("b", 1, 10, 1)};
    for (MeasuredJob& job : jobs) job.reference_error["relative_mse"] = 0.0004;
    const ComparisonTable table = make_table(jobs, {"relative_mse"});
    // 0.1 / 102.4 = 0.00098 is within 3 x 0.0004; 0.098 is not.
    EXPECT_TRUE(table.rows[0].error.at("relative_mse").near_reference);
    EXPECT_FALSE(table.rows[1].error.at("relative_mse").near_reference);
    EXPECT_EQ(table.rows[1].error.at("relative_mse").reference, 0.0004);
}

/// A power law measured against two references: each point is known to that half of a width.
MeasuredJob cross_measured(const std::string& label, uint64_t seed, double scale, double half) {
    MeasuredJob job = power_law(label, seed, scale, 1);
    for (CurvePoint& point : job.curve) {
        const double error = *point.metrics["relative_mse"];
        point.intervals["relative_mse"] = {error - half, error + half};
    }
    const CurvePoint& last = job.curve.back();
    job.error["relative_mse"] = *last.metrics.at("relative_mse");
    job.error_interval["relative_mse"] = last.intervals.at("relative_mse");
    return job;
}

TEST(ComparisonTable, MeansOfErrorsWithIntervalsAreOfTheErrors) {
    // 4, -1 and 3: mean 2, of the widths 2, 4 and 6 about them the mean 4. 1, 2 and 4 without: mean 2 of logarithms.
    const std::vector<TimedError> known{{1, 4, Interval{3, 5}}, {1, -1, Interval{-3, 1}}, {1, 3, Interval{0, 6}}};
    const MeanError mean = *mean_error(known);
    EXPECT_NEAR(mean.error.mean, 2, 1e-14);
    EXPECT_NEAR(mean.interval->least, 0, 1e-14);
    EXPECT_NEAR(mean.interval->greatest, 4, 1e-14);
    EXPECT_FALSE(mean.is_bound());
    EXPECT_EQ(*mean.drawn(), mean.error.mean);
    EXPECT_NEAR(*mean.error.high, 2 + 4.302653 * std::sqrt(7.0 / 3), 1e-5);
    EXPECT_NEAR(mean_error(std::vector<TimedError>{{1, 1}, {1, 2}, {1, 4}})->error.mean, 2, 1e-14);
    EXPECT_NEAR(mean_error(std::vector<TimedError>{{1, 1}, {1, 0}, {1, 5}})->error.mean, 2, 1e-14);
    EXPECT_FALSE(mean_error(std::vector<TimedError>{{1, 1, Interval{0, 2}}, {1, 2}})->interval);
    EXPECT_FALSE(mean_error({}));
    const auto drawn = [](double error, std::optional<Interval> interval) {
        return MeanError{{error, {}, {}}, interval}.drawn();
    };
    EXPECT_EQ(drawn(-1, Interval{-2, 4}), 4);
    EXPECT_EQ(drawn(-1, Interval{-4, 2}), 3) << "no reference shows an error below half of the width";
    EXPECT_EQ(drawn(-3, Interval{-4, -2}), 1) << "an upper end below 0 bounds nothing";
    EXPECT_FALSE(drawn(0, std::nullopt));
}

TEST(ComparisonTable, TheReferencesNoiseIsSharedByTheSeeds) {
    // At the end 0.1 / 102.4 = 0.00098 and twice that, known to 0.0004 and 0.0006.
    const std::vector<MeasuredJob> jobs{cross_measured("a", 1, 0.1, 0.0004), cross_measured("a", 2, 0.2, 0.0006),
                                        cross_measured("b", 1, 0.1, 0.0002), cross_measured("b", 2, 0.2, 0.0002)};
    const ComparisonTable table = make_table(jobs, {"relative_mse"});
    const FinalError& end = table.rows[0].error.at("relative_mse");
    const double mean = 0.15 / 102.4;
    EXPECT_NEAR(end.mean->error.mean, mean, 1e-12);
    EXPECT_NEAR(end.mean->interval->least, mean - 0.0005, 1e-12);
    EXPECT_NEAR(end.mean->interval->greatest, mean + 0.0005, 1e-12);
    EXPECT_TRUE(end.near_reference) << "0.0005 is more than a third of 0.00146";
    EXPECT_FALSE(table.rows[1].error.at("relative_mse").near_reference);
    // At 10 s 0.01 and 0.02; what the ends lie off is linear between points.
    const MeanError& then = *time_of(table.rows[0], 10).mean;
    EXPECT_NEAR(then.error.mean, 0.015, 1e-12);
    EXPECT_NEAR(then.interval->greatest, 0.0155, 1e-12);
    // Seeds are at 0.02 + 0.0004 and 0.02 + 0.0006 at the latest.
    const TimeToError& level = level_of(table.rows[0], 0.02);
    EXPECT_NEAR(*level.latest, level.seconds->mean, 1e-12);
    EXPECT_GT(level.seconds->mean, std::sqrt(5.0 * 10));
    EXPECT_LT(*level.earliest, std::sqrt(5.0 * 10));
    const json row = to_json(table)[0];
    EXPECT_NEAR(row["error"]["relative_mse"]["interval"][0].get<double>(), mean - 0.0005, 1e-12);
    EXPECT_TRUE(row["bias"].is_null());
    EXPECT_NEAR(mean_curves_json(table.rows[0])["relative_mse"].back()["interval"][1].get<double>(), mean + 0.0005,
                1e-12);
}

TEST(ComparisonTable, WhatIsNotPositiveIsThere) {
    // From 12.8 s on the estimate is 0.005 below the truth: negative from 25.6 s on, its upper end positive.
    MeasuredJob job = cross_measured("a", 1, 0.1, 0.006);
    for (size_t i = 7; i < job.curve.size(); ++i) {
        CurvePoint& point = job.curve[i];
        const double error = *point.metrics["relative_mse"] - 0.005;
        point.metrics["relative_mse"] = error;
        point.intervals["relative_mse"] = {error - 0.006, error + 0.006};
        point.metrics["rmse"] = error > 0 ? std::optional(std::sqrt(error)) : std::nullopt;
        point.intervals["rmse"] = {0, std::sqrt(error + 0.006)};
    }
    job.error = {{"relative_mse", *job.curve.back().metrics["relative_mse"]}};
    job.error_interval = job.curve.back().intervals;
    const ComparisonTable table = make_table(std::vector{job}, {"relative_mse", "rmse"});
    const TableRow& row = table.rows[0];
    const MeanPoint& last = row.mean_curve.at("relative_mse").back();
    EXPECT_NEAR(last.mean.error.mean, 0.1 / 102.4 - 0.005, 1e-12);
    EXPECT_NEAR(*last.mean.drawn(), 0.006, 1e-12) << "half of the width: the upper end is lower by luck";
    EXPECT_TRUE(row.error.at("relative_mse").near_reference);
    EXPECT_EQ(row.error.at("rmse").mean->error.mean, 0) << "the root of what is below 0";
    EXPECT_NEAR(row.error.at("rmse").mean->interval->greatest, std::sqrt(0.1 / 102.4 + 0.001), 1e-12);
    // No level below 0.006, half of the width, is reached, whatever the estimates.
    for (const TimeToError& level : row.time_to_error.at("relative_mse"))
        EXPECT_EQ(level.seconds.has_value(), level.error >= 0.006) << level.error;
    EXPECT_FALSE(row.efficiency) << "the mean square was not measured, and its root is 0";
}

TEST(ComparisonTable, EfficiencyIsOfTheMeanSquareTimesSeconds) {
    std::vector<MeasuredJob> jobs{power_law("a", 1, 0.1, 1), power_law("a", 2, 0.1, 1)};
    jobs[0].error = {{"mse", 0.003}, {"rmse", 9}};
    jobs[1].error = {{"mse", -0.001}};
    EXPECT_NEAR(*make_table(jobs, {"relative_mse"}).rows[0].efficiency, 1 / (0.001 * 102.4), 1e-9);
    jobs[1].error = {{"mse", -0.004}};
    EXPECT_FALSE(make_table(jobs, {"relative_mse"}).rows[0].efficiency);
    jobs[1].error = {{"rmse", 0.1}};  // of before: 0.01
    EXPECT_NEAR(*make_table(jobs, {"relative_mse"}).rows[0].efficiency, 1 / (0.0065 * 102.4), 1e-9);
    for (MeasuredJob& job : jobs) job.error = {{"mse", 7}, {"indirect:mse", 0.002}};
    EXPECT_NEAR(*make_table(jobs, {"indirect:relative_mse"}).rows[0].efficiency, 1 / (0.002 * 102.4), 1e-9);
}

TEST(ComparisonTable, GivesWhatAnErrorIsMadeOf) {
    ComparisonTable table = make_table(std::vector{power_law("a", 1, 0.1, 1)}, {"relative_mse"});
    table.rows[0].bias.emplace()["relative_mse"] = {0.02, 0.01, 0.03, 0.005, {}, {}, true, "a sentence"};
    EXPECT_EQ(to_json(table)[0]["bias"],
              json::parse(R"({"relative_mse": {"squared_bias": 0.02, "low": 0.01, "high": 0.03, "variance": 0.005,
                              "variance_low": null, "variance_high": null, "floor": true, "text": "a sentence"}})"));
    BiasApart parts{0.02, 0.01, 0.03, 0.005, {}, {}, true, ""};
    EXPECT_EQ(parts.least(), 0.01);
    parts.low = -0.001;
    EXPECT_FALSE(parts.least()) << "it may have none";
    parts = {0.02, 0.01, 0.03, 0.005, {}, {}, false, ""};
    EXPECT_FALSE(parts.least()) << "more passes make it less";
}

TEST(MeasuredJob, TakesIntervalsFromTheWire) {
    MeasuredJob job;
    add_measurements(
        job, json::parse(R"([{"seconds": 1, "passes": 2, "photons": null, "metrics": {"mse": -1, "rmse": null},
                                           "intervals": {"mse": [-3, 1], "rmse": [0, 1]}},
                                          {"seconds": 2, "passes": 4, "photons": 8, "metrics": {"mse": 1}}])"),
        json::parse(R"({"error": {"mse": -1, "rmse": null}, "error_interval": {"mse": [-3, 1], "rmse": [0, 1]},
                                     "reference_error": null})"));
    ASSERT_EQ(job.curve.size(), 2u);
    EXPECT_EQ(job.curve[0].intervals.at("mse"), (Interval{-3, 1}));
    EXPECT_TRUE(job.curve[1].intervals.empty());
    EXPECT_EQ(job.error_interval.at("rmse"), (Interval{0, 1}));
    EXPECT_FALSE(job.error.contains("rmse"));
    MeasuredJob older;
    add_measurements(older, json(), json::parse(R"({"error": {"mse": 1}, "error_interval": null})"));
    EXPECT_TRUE(older.error_interval.empty());
}

TEST(ComparisonTable, ShowsWhatIsThere) {
    MeasuredJob queued = power_law("b", 1, 1, 1);
    queued.state = "queued";
    queued.curve.clear();
    MeasuredJob failed = power_law("a", 2, 0.1, 1, 0.1, 0.8);
    failed.state = "failed";
    std::vector<MeasuredJob> jobs{power_law("a", 1, 0.1, 1), failed, queued};
    jobs[0].peak_bytes = 1000;
    jobs[0].photons = 5000;
    const ComparisonTable table = make_table(jobs, {"relative_mse", "flip_hdr"});
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_EQ(table.rows[0].succeeded, 1u);
    EXPECT_EQ(table.rows[0].seconds->max, 102.4);
    EXPECT_EQ(table.rows[0].peak_bytes, 1000u);
    EXPECT_TRUE(table.rows[0].pareto);
    EXPECT_FALSE(table.rows[1].pareto);
    EXPECT_EQ(level_of(table.rows[0], 0.5).reached, 2u);
    EXPECT_EQ(level_of(table.rows[1], 0.5).reached, 0u);
    EXPECT_TRUE(table.rows[0].time_to_error.at("flip_hdr").empty());
    const json rows = to_json(table);
    EXPECT_EQ(rows[0]["photons"], json::parse(R"({"min": 5000, "max": 5000})"));
    EXPECT_TRUE(rows[1]["seconds"].is_null());
    EXPECT_TRUE(rows[1]["error"]["relative_mse"]["value"].is_null());
    EXPECT_TRUE(to_json(make_table({}, {"rmse"})).empty());
}

TEST(ComparisonTable, SeedsThatShareNoTimeShowTheirEnd) {
    std::vector<MeasuredJob> jobs{power_law("a", 1, 0.1, 1, 1, 1), power_law("a", 2, 0.1, 1, 4, 4)};
    const ComparisonTable table = make_table(jobs, {"relative_mse"});
    const std::vector<MeanPoint>& curve = table.rows[0].mean_curve.at("relative_mse");
    ASSERT_EQ(curve.size(), 1u);
    EXPECT_NEAR(curve[0].seconds, 2, 1e-12);
    EXPECT_NEAR(curve[0].mean.error.mean, 0.05, 1e-12);
}

TEST(ParetoFront, KeepsWhatIsBestAtSomeTime) {
    using Curve = std::vector<TimedError>;
    const Curve early{{1, 1}, {2, 0.8}, {100, 0.7}};   // best at first
    const Curve late{{10, 0.5}, {100, 0.1}};           // best later
    const Curve worse{{2, 0.9}, {50, 0.75}};           // never
    const Curve crossing{{1, 2}, {4, 0.6}, {5, 0.6}};  // below `early` between its points
    EXPECT_EQ(pareto_front(std::vector<Curve>{early, late, worse, {}}), (std::vector<bool>{true, true, false, false}));
    EXPECT_EQ(pareto_front(std::vector<Curve>{early, crossing}), (std::vector<bool>{true, true}));
    EXPECT_EQ(pareto_front(std::vector<Curve>{early, early}), (std::vector<bool>{true, true}));
    // One that stopped earlier still excludes what comes later and is no better.
    EXPECT_EQ(pareto_front(std::vector<Curve>{{{1, 0.1}}, {{5, 0.1}, {6, 0.1}}}), (std::vector<bool>{true, false}));
}

TEST(RoundLevels, AreTheNearestDoubles) {
    EXPECT_EQ(round_levels(0.0004, 0.02), (std::vector<double>{5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2}));
    EXPECT_EQ(round_levels(20, 200), (std::vector<double>{20, 50, 100, 200}));
    EXPECT_TRUE(round_levels(0.3, 0.4).empty());
    EXPECT_EQ(round_level_above(0.3), 0.5);
    EXPECT_EQ(round_level_above(1e-6), 1e-6);
}

TEST(ReportCsv, HasALineForEachPointAndQuotesLabels) {
    MeasuredJob job = power_law("a, \"b\"\n", 7, 1, 1, 0.1, 0.2);
    job.id = "J1";
    job.parameters = {{"photons", 5}};
    job.curve[0].photons = 50;
    job.curve[0].metrics["rmse"] = 3.5;
    job.curve[1].metrics["rmse"] = 2.25;
    job.curve[1].metrics["flip_hdr"] = std::nullopt;
    const std::string csv = report_csv(std::vector{job}, {"rmse", "flip_hdr"});
    EXPECT_EQ(csv,
              "label,parameters,seed,job,seconds,passes,photons,rmse,flip_hdr,relative_mse\r\n"
              "\"a, \"\"b\"\"\n\",\"{\"\"photons\"\":5}\",7,J1,0.1,1,50,3.5,,10.0\r\n"
              "\"a, \"\"b\"\"\n\",\"{\"\"photons\"\":5}\",7,J1,0.2,2,,2.25,,5.0\r\n");
}

TEST(ReportCsv, PutsIntervalsLast) {
    MeasuredJob job = power_law("a", 7, 1, 1, 0.1, 0.2);
    job.id = "J1";
    job.curve[1].metrics.erase("rmse");
    job.curve[1].intervals = {{"rmse", {0, 2.5}}};
    const std::string csv = report_csv(std::vector{job}, {"relative_mse"});
    EXPECT_EQ(csv.substr(0, csv.find("\r\n")),
              "label,parameters,seed,job,seconds,passes,photons,relative_mse,rmse,rmse least,rmse greatest");
    EXPECT_NE(csv.find("0.1,1,,10.0,3.16"), std::string::npos) << csv;
    EXPECT_NE(csv.find(",,\r\n"), std::string::npos) << csv;
    EXPECT_NE(csv.find("0.2,2,,5.0,,0.0,2.5\r\n"), std::string::npos) << csv;
}

}  // namespace
}  // namespace photond::comparison_table_test

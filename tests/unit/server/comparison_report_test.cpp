// The page of a comparison: what it says of the tables, and that nothing of a name gets out of its place.

#include "server/comparisons/report_html.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "server/comparisons/exposure.h"
#include "server/comparisons/plot.h"
#include "server/comparisons/report_text.h"
#include "server/comparisons/verdict.h"
#include "tests/support/temporary_folder.h"

namespace photond::comparison_report_test {
namespace {

using nlohmann::json;

/// error = scale / seconds, from 0.5 s to 16 s and, which bears that out, at 32 s.
MeasuredJob job(const std::string& label, uint64_t seed, double scale) {
    MeasuredJob made;
    made.id = "J" + std::to_string(seed);
    made.label = label;
    made.parameters = json::object();
    made.seed = seed;
    made.state = "succeeded";
    for (double seconds = 0.5; seconds <= 32; seconds *= 2)
        made.curve.push_back({seconds, static_cast<uint32_t>(seconds * 2), {}, {{"relative_mse", scale / seconds}}});
    made.passes = 64;
    made.seconds = 32;
    return made;
}

Report report_of(const std::vector<MeasuredJob>& jobs, const std::string& label) {
    Report report;
    report.table = make_table(jobs, {"relative_mse"});
    json listed = json::array();
    for (const MeasuredJob& made : jobs)
        listed.push_back({{"id", made.id},
                          {"label", made.label},
                          {"parameters", made.parameters},
                          {"seed", made.seed},
                          {"state", made.state},
                          {"passes_done", made.passes},
                          {"seconds", made.seconds}});
    report.comparison = {{"id", "C1"},
                         {"state", "succeeded"},
                         {"created", "2026-01-01T00:00:00Z"},
                         {"overhead_seconds", 1.5},
                         {"job_states", {{"succeeded", jobs.size()}}},
                         {"jobs", listed},
                         {"reference", nullptr},
                         {"warnings", {"a, seed 1: J1 lost 2 s <of its processor time>"}},
                         {"request",
                          {{"scene", label},
                           {"image", {{"width", 8}, {"height", 4}}},
                           {"seeds", {1, 2}},
                           {"stop", {{"seconds", 10}, {"passes", nullptr}, {"target", nullptr}}},
                           {"reference", nullptr},
                           {"entries", {{{"label", label}}}}}}};
    report.statistics.resize(jobs.size());
    report.version = "1";
    return report;
}

TEST(ReportHtml, NamesStayText) {
    const std::string label = "<script>alert(\"1\" & '2')</script>";
    Report report = report_of({job(label, 1, 1), job(label + "2", 2, 2)}, label);
    report.pictures.push_back({ReportPicture::Kind::Beauty, label, label, {1, 2, 3, 4}});
    report.notes = {label};
    const std::string page = report_html(report);
    EXPECT_EQ(page.find("alert(\""), std::string::npos);
    EXPECT_NE(page.find("&lt;script&gt;alert(&quot;1&quot; &amp; &#39;2&#39;)&lt;/script&gt;"), std::string::npos);
    size_t scripts = 0;
    for (size_t at = page.find("<script"); at != std::string::npos; at = page.find("<script", at + 1)) ++scripts;
    EXPECT_EQ(scripts, 1u);
    EXPECT_NE(page.find("src=\"data:image/png;base64,AQIDBA==\""), std::string::npos);
}

TEST(ReportHtml, ThePolicyNamesItsOwnStyleAndScript) {
    const std::string policy = report_content_security_policy("<style>a{}</style><script>b()</script>");
    // printf %s 'a{}' | openssl dgst -sha256 -binary | base64, and of 'b()'.
    EXPECT_NE(policy.find("style-src 'sha256-X1RutGBrXCt9KkSaXMK7tHftWiRscFHOhxsS8tv8hBk='"), std::string::npos)
        << policy;
    EXPECT_NE(policy.find("script-src 'sha256-cf242PFc/kb7xD0Qzhsmd9vvRkc+cWFmbi+k+YvtdKc='"), std::string::npos)
        << policy;
    EXPECT_EQ(policy.find("unsafe"), std::string::npos);
}

TEST(ReportHtml, SaysWhoIsFirst) {
    // 1 / t and 2 / t with two seeds each, a tenth apart.
    const std::vector<MeasuredJob> jobs{job("a", 1, 1), job("a", 2, 1.1), job("b", 1, 2), job("b", 2, 2.2)};
    const ComparisonTable table = make_table(jobs, {"relative_mse"});
    const std::vector<Verdict> found = verdicts(table);
    // With two seeds a tenth apart the intervals are wide: nobody is first until b is not there at all.
    ASSERT_EQ(found.size(), 2u);
    EXPECT_TRUE(found[0].close);
    EXPECT_DOUBLE_EQ(found[0].error, 0.2);
    EXPECT_EQ(verdict_text(table, found[0]),
              "too close to call at relative_mse 0.2: a (5.24 s) and b (10.5 s); likewise from 2 on");
    EXPECT_FALSE(found[1].close);
    EXPECT_EQ(verdict_text(table, found[1]), "a reaches relative_mse 0.1 first, after 10.5 s; not in its time: b");
    EXPECT_TRUE(verdicts(make_table(std::vector{jobs[0]}, {"relative_mse"})).empty());
}

TEST(ReportHtml, SaysHowMuchSooner) {
    const ComparisonTable table =
        make_table(std::vector{job("a", 1, 1), job("b", 1, 3), job("c", 1, 3.1)}, {"relative_mse"});
    const json found = verdicts_json(table, verdicts(table));
    ASSERT_EQ(found.size(), 2u) << found.dump(1);
    EXPECT_EQ(found[0]["text"],
              "a reaches relative_mse 0.2 first, after 5 s: 3 times sooner than b (15 s); then c (15.5 s); likewise "
              "from 5 on");
    EXPECT_NEAR(found[0]["factor"].get<double>(), 3, 1e-9);
    EXPECT_EQ(found[0]["arrived"][2]["row"], 2);
    EXPECT_EQ(found[1]["text"], "a reaches relative_mse 0.1 first, after 10 s; not in its time: b, c");
    EXPECT_TRUE(found[1]["factor"].is_null());
}

/// A curve against two references: known to that half of a width.
MeasuredJob cross_job(const std::string& label, uint64_t seed, double scale, double half) {
    MeasuredJob made = job(label, seed, scale);
    for (CurvePoint& point : made.curve) {
        const double error = *point.metrics["relative_mse"];
        point.intervals["relative_mse"] = {error - half, error + half};
    }
    return made;
}

TEST(ReportHtml, TellsSingleSeedsApartByTheReferencesNoise) {
    // 1 / t and 1.2 / t: at 0.1 after 10 s and 12 s, where 0.001 is a hundredth of the error and 0.02 a fifth.
    const auto text = [](double half) {
        const ComparisonTable table =
            make_table(std::vector{cross_job("a", 1, 1, half), cross_job("b", 1, 1.2, half)}, {"relative_mse"});
        const std::vector<Verdict> found = verdicts(table);
        return verdict_text(table, found.back());
    };
    EXPECT_EQ(text(0.0001).find("a reaches relative_mse 0.1 first"), 0u) << text(0.0001);
    EXPECT_EQ(text(0.02).find("too close to call at relative_mse 0.1: a"), 0u) << text(0.02);
}

TEST(ReportHtml, WhatIsNotShownToArriveMayHave) {
    // b's noise is greater: 0.1 it never shows to have reached, by its lower ends it may have at once.
    const ComparisonTable table =
        make_table(std::vector{cross_job("a", 1, 1, 0.001), cross_job("b", 1, 1, 0.2)}, {"relative_mse"});
    const std::vector<Verdict> found = verdicts(table);
    EXPECT_TRUE(found.back().close);
    EXPECT_EQ(found.back().open, std::vector<size_t>{1});
    EXPECT_EQ(
        verdict_text(table, found.back()),
        "too close to call at relative_mse 0.1: a (10.1 s); the references' noise leaves open whether b was there "
        "sooner; likewise from 0.2 on");
}

TEST(ReportHtml, WhatCanBeToldApartIsNotTooClose) {
    // c arrives later than a for certain: only b and d, which are known less well, leave it open who was first.
    const ComparisonTable table = make_table(std::vector{cross_job("a", 1, 1, 0.001), cross_job("b", 1, 1, 0.2),
                                                         cross_job("c", 1, 1.5, 0.001), cross_job("d", 1, 1, 0.2)},
                                             {"relative_mse"});
    const Verdict last = verdicts(table).back();
    EXPECT_EQ(last.error, 0.1);
    EXPECT_TRUE(last.close && last.rivals.empty());
    const std::string text = verdict_text(table, last);
    EXPECT_EQ(text.find("too close to call at relative_mse 0.1: a (10.1 s); then c (15.2 s); the references' noise "
                        "leaves open whether b and d were there sooner"),
              0u)
        << text;
}

TEST(ReportHtml, NamesAllThatCannotBeToldApart) {
    // b and c are known less well and arrive later, and might be as soon as a; d arrives between them and cannot.
    const ComparisonTable table = make_table(std::vector{cross_job("a", 1, 1, 0.0001), cross_job("b", 1, 1.01, 0.03),
                                                         cross_job("c", 1, 1.1, 0.03), cross_job("d", 1, 1.5, 0.0001)},
                                             {"relative_mse"});
    const std::vector<Verdict> found = verdicts(table);
    EXPECT_EQ(found.back().rivals, (std::vector<size_t>{1, 2})) << verdict_text(table, found.back());
    EXPECT_NE(verdict_text(table, found.back()).find("; then d ("), std::string::npos);
}

TEST(ReportHtml, SaysWhatABiasedRowComesTo) {
    std::vector<MeasuredJob> jobs{cross_job("a", 1, 1, 0.001), cross_job("b", 1, 3, 0.001)};
    ComparisonTable table = make_table(jobs, {"relative_mse"});
    table.rows[1].bias.emplace()["relative_mse"] = {0.0816, 0.0792, 0.084, 0.01, {}, {}, true, "biased"};
    Verdict last = verdicts(table).back();
    EXPECT_EQ(last.error, 0.1);
    EXPECT_EQ(verdict_text(table, last), "a reaches relative_mse 0.1 first, after 10.1 s; not in its time: b");
    table.rows[1].bias->at("relative_mse").low = 0.132;
    EXPECT_EQ(verdict_text(table, last),
              "a reaches relative_mse 0.1 first, after 10.1 s; b reaches no less than relative_mse 0.132");
    table.rows[1].bias->at("relative_mse").floor = false;
    EXPECT_NE(verdict_text(table, last).find("not in its time: b"), std::string::npos);

    Report report = report_of(jobs, "scene");
    report.table.rows[1].bias = table.rows[1].bias;
    EXPECT_EQ(report_html(report).find("class=\"bias-floor"), std::string::npos);
    EXPECT_NE(report_html(report).find("b: biased</li>"), std::string::npos);
    report.table.rows[1].bias->at("relative_mse").floor = true;
    EXPECT_NE(report_html(report).find("class=\"bias-floor line-1\""), std::string::npos);
    EXPECT_NE(report_html(report).find("b: no less than 0.132"), std::string::npos);
}

TEST(ReportHtml, ARootHasTheFloorOfItsMeanSquare) {
    std::vector<MeasuredJob> jobs{cross_job("a", 1, 1, 0.001), cross_job("b", 1, 3, 0.001)};
    for (MeasuredJob& made : jobs)
        for (CurvePoint& point : made.curve) {
            point.metrics["rmse"] = point.metrics["relative_mse"];
            point.intervals["rmse"] = point.intervals["relative_mse"];
        }
    Report report = report_of(jobs, "scene");
    report.table = make_table(jobs, {"rmse"});
    report.table.rows[1].bias.emplace()["mse"] = {0.0169, 0.0144, 0.0196, 0.01, {}, {}, true, "biased"};
    EXPECT_NEAR(*floor_of(report.table.rows[1], "rmse"), 0.12, 1e-12);
    EXPECT_EQ(floor_of(report.table.rows[1], "mse"), 0.0144);
    EXPECT_FALSE(floor_of(report.table.rows[1], "indirect:rmse"));
    EXPECT_FALSE(floor_of(report.table.rows[1], "mae"));
    EXPECT_FALSE(floor_of(report.table.rows[0], "rmse"));
    EXPECT_NE(report_html(report).find("b: no less than 0.12<"), std::string::npos);
    EXPECT_NE(report_html(report).find("b: biased</li>"), std::string::npos);
    const Verdict last = verdicts(report.table).back();
    EXPECT_EQ(last.error, 0.1);
    EXPECT_NE(verdict_text(report.table, last).find("b reaches no less than rmse 0.12"), std::string::npos);
}

TEST(ReportHtml, MarksUpperBounds) {
    MeasuredJob made = cross_job("a", 1, 1, 0.05);
    for (size_t i = 5; i < made.curve.size(); ++i) {  // from 16 s on
        made.curve[i].metrics["relative_mse"] = -0.01;
        made.curve[i].intervals["relative_mse"] = {-0.06, 0.04};
    }
    const std::string page = report_html(report_of({made}, "scene"));
    size_t arrows = 0;
    for (size_t at = page.find("<path class=\"bound"); at != std::string::npos;
         at = page.find("<path class=\"bound", at + 1))
        ++arrows;
    EXPECT_EQ(arrows, 2u);
    EXPECT_NE(page.find("&lt; 0.05<small>ref. -0.06 – 0.04</small>"), std::string::npos)
        << "half of the width, for the upper end is lower by luck";
    EXPECT_NE(page.find("class=\"whisker line-0\""), std::string::npos);
    EXPECT_NE(page.find("arrows down: upper bounds"), std::string::npos);
    EXPECT_NE(page.find("not known to a third (!)"), std::string::npos);
    EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(Plot, NoLuckyPointDrawsTheAxisDown) {
    const auto height_of_first = [](double lucky) {
        const Plot plot{"t",
                        "e",
                        {{"a", {{1, {{1, {}, {}}, Interval{0.9, 1.1}}}, {10, {{lucky, {}, {}}, Interval{-0.2, 0.3}}}}}},
                        {}};
        const std::string svg = log_log_plot(plot);
        double x = 0, y = 0;
        EXPECT_EQ(std::sscanf(svg.c_str() + svg.find("<circle"), "<circle class=\"point line-0\" cx=\"%lf\" cy=\"%lf",
                              &x, &y),
                  2);
        return y;
    };
    EXPECT_EQ(height_of_first(1e-9), height_of_first(0.03)) << "an error is drawn to a tenth of its upper end";
    EXPECT_NE(height_of_first(1e-9), height_of_first(0.1));
}

TEST(ReportHtml, SaysHowErrorsWereMeasured) {
    Report report = report_of({job("a", 1, 1)}, "scene");
    const auto says = [&](const char* what) { return report_html(report).find(what) != std::string::npos; };
    EXPECT_FALSE(says("Measured against"));
    report.comparison["reference"] = {{"form", "two_films"}, {"warnings", json::array()}};
    EXPECT_TRUE(says("Measured against two films"));
    report.comparison["reference"]["form"] = "image";
    EXPECT_TRUE(says("Measured against one image"));
    report.comparison["reference"].erase("form");  // as before there were two films
    EXPECT_TRUE(says("Measured against one film"));
}

TEST(ReportHtml, BeginsWithTheHeadline) {
    const std::string page = report_html(report_of({job("a & c", 1, 1), job("b", 2, 2)}, "scene"));
    EXPECT_NE(page.find("By relative_mse: a &amp; c is better here.</p>"), std::string::npos);
    EXPECT_LT(page.find("is better here"), page.find("reaches relative_mse"));
    EXPECT_EQ(report_html(report_of({job("a", 1, 1)}, "scene")).find("class=\"headline\""), std::string::npos);
}

TEST(ReportHtml, MarksWhatIsUnfinished) {
    Report report = report_of({job("a", 1, 1), job("b", 2, 2)}, "scene");
    EXPECT_EQ(report_html(report).find("Unfinished"), std::string::npos);
    report.comparison["state"] = "running";
    EXPECT_NE(report_html(report).find("Unfinished: 2 of 2 jobs"), std::string::npos);
}

TEST(Plot, PlacesADecadeAsLongAsTheNext) {
    Plot plot{"t", "e", {{"a", {{1, {{1, {}, {}}}}, {10, {{0.1, 0.05, 0.2}}}, {100, {{0.01, {}, {}}}}}}}, 0.02};
    const std::string svg = log_log_plot(plot);
    const size_t begin = svg.find("<polyline");
    const std::string points = svg.substr(svg.find("points=\"", begin) + 8, 60);
    double x[3], y[3];
    ASSERT_EQ(std::sscanf(points.c_str(), "%lf,%lf %lf,%lf %lf,%lf", &x[0], &y[0], &x[1], &y[1], &x[2], &y[2]), 6);
    EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.02);
    EXPECT_NEAR(y[1] - y[0], y[2] - y[1], 0.02);
    EXPECT_GT(y[1], y[0]) << "a smaller error lies lower";
    EXPECT_NE(svg.find("the reference&#39;s own noise, 0.02"), std::string::npos);
    EXPECT_TRUE(log_log_plot({"t", "e", {{"a", {}}}, {}}).empty());
}

TEST(ReportText, WritesNumbersShortly) {
    EXPECT_EQ(short_number(0.0012345), "0.00123");
    EXPECT_EQ(short_number(12.345), "12.3");
    EXPECT_EQ(short_number(2), "2");
    EXPECT_EQ(short_number(100000), "100000");
    EXPECT_EQ(short_number(1.2345e-7), "1.23e-7");
    for (const double level : {0.1, 0.02, 5e-5, 2000.0, 2e6}) EXPECT_EQ(exact_number(level), short_number(level));
    EXPECT_EQ(exact_number(0.0012345), "0.0012345");
    for (const double value : {1.0 / 3, std::nextafter(0.001, 0), 1e5 / 7, std::nextafter(1e-9, 1)})
        EXPECT_EQ(std::stod(exact_number(value)), value);
    EXPECT_EQ(short_seconds(0.0123), "12.3 ms");
    EXPECT_EQ(short_seconds(200), "3 min 20 s");
    EXPECT_EQ(short_seconds(7200), "2 h");
    EXPECT_EQ(short_bytes(12'345'678), "12.3 MB");
    const std::vector<uint8_t> bytes{'f', 'o', 'o', 'b', 'a'};  // RFC 4648, 10
    EXPECT_EQ(base64(bytes), "Zm9vYmE=");
    EXPECT_EQ(base64(std::span(bytes).first(4)), "Zm9vYg==");
    EXPECT_EQ(base64({}), "");
}

TEST(Exposure, BringsTheLogAverageToMiddleGrey) {
    const TemporaryFolder folder;
    const auto stops = [&](const std::vector<float>& pixels) {
        const std::filesystem::path path = folder.path() / "pixels";
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(pixels.data()),
                   static_cast<std::streamsize>(pixels.size() * sizeof(float)));
        return exposure_stops(path);
    };
    const float nan = std::nanf("");
    EXPECT_EQ(stops({0.18f, 0.18f, 0.18f}), 0);
    EXPECT_EQ(stops({0.09f, 0.09f, 0.09f, 0, 0, 0, nan, 1, 1}), 1);
    EXPECT_EQ(stops({0.09f, 0.09f, 0.09f, 1.44f, 1.44f, 1.44f}), -1);
    EXPECT_EQ(stops({0, 0, 0}), 0);
}

}  // namespace
}  // namespace photond::comparison_report_test

// Disturbed jobs of a comparison: which of a place's jobs counts, when the daemon repeats one by itself, and what
// verdicts are worth that rest on one.

#include "server/comparisons/repeats.h"

#include <gtest/gtest.h>

#include "server/comparisons/headline.h"
#include "server/comparisons/verdict.h"

namespace photond::repeats_test {
namespace {

MeasuredJob run_of(const std::string& state, double share = 1) {
    MeasuredJob run;
    run.state = state;
    if (share < 1) run.loss = CoreLoss{share, 1, 1, {{"others", 1}}};
    return run;
}
using Runs = std::vector<MeasuredJob>;

TEST(Repeats, TheFirstUndisturbedRunCountsElseTheLeastDisturbed) {
    EXPECT_EQ(run_that_counts(Runs{run_of("succeeded", 0.9), run_of("succeeded"), run_of("succeeded")}), 1u);
    EXPECT_EQ(run_that_counts(Runs{run_of("succeeded"), run_of("succeeded")}), 0u);
    EXPECT_EQ(run_that_counts(Runs{run_of("succeeded", 0.7), run_of("succeeded", 0.9), run_of("succeeded", 0.8)}), 1u);
    EXPECT_EQ(run_that_counts(Runs{run_of("succeeded", 0.9), run_of("running")}), 0u) << "while it is repeated";
    EXPECT_EQ(run_that_counts(Runs{run_of("succeeded", 0.9), run_of("failed")}), 0u);
    EXPECT_EQ(run_that_counts(Runs{run_of("failed"), run_of("succeeded", 0.5)}), 1u);
    EXPECT_EQ(run_that_counts(Runs{run_of("failed"), run_of("cancelled")}), 0u);
}

TEST(Repeats, TwiceAtMostAndOnlyWhatWasDisturbed) {
    EXPECT_FALSE(is_to_be_repeated(Runs{run_of("succeeded")}, 2));
    EXPECT_TRUE(is_to_be_repeated(Runs{run_of("succeeded", 0.9)}, 2));
    EXPECT_TRUE(is_to_be_repeated(Runs{run_of("succeeded", 0.9), run_of("succeeded", 0.9)}, 2));
    EXPECT_FALSE(
        is_to_be_repeated(Runs{run_of("succeeded", 0.9), run_of("succeeded", 0.9), run_of("succeeded", 0.9)}, 2));
    EXPECT_FALSE(is_to_be_repeated(Runs{run_of("succeeded", 0.9)}, 0));
    EXPECT_FALSE(is_to_be_repeated(Runs{run_of("succeeded", 0.9), run_of("succeeded")}, 2));
    EXPECT_FALSE(is_to_be_repeated(Runs{run_of("failed")}, 2));
    EXPECT_FALSE(is_to_be_repeated(Runs{run_of("succeeded", 0.9), run_of("cancelled")}, 2)) << "nobody wants it";
    EXPECT_FALSE(is_to_be_repeated(Runs{run_of("succeeded", 0.9), run_of("running")}, 2));
}

/// error = scale / seconds, until `last_s`.
MeasuredJob measured(const std::string& label, double scale, double clock_lost_s, double last_s = 32) {
    MeasuredJob job;
    job.id = "J" + label;
    job.label = label;
    job.parameters = nlohmann::json::object();
    job.state = "succeeded";
    for (double seconds = 0.5; seconds <= last_s; seconds *= 2)
        job.curve.push_back({seconds, static_cast<uint32_t>(seconds * 2), {}, {{"rmse", scale / seconds}}});
    job.seconds = last_s;
    if (clock_lost_s > 0) job.loss = CoreLoss{0.8, 2 * clock_lost_s, clock_lost_s, {{"others", 2 * clock_lost_s}}};
    return job;
}

/// Of the smallest error.
std::string last_verdict(const Runs& jobs, const TableWishes& wishes = {{}, 32.0}) {
    const ComparisonTable table = make_table(jobs, {"rmse"}, wishes);
    return verdict_text(table, verdicts(table).back());
}

TEST(DisturbedVerdict, WhatWasLostMustNotDecide) {
    // a is at 0.1 after 10 s, b after 15 s.
    EXPECT_EQ(last_verdict({measured("a", 1, 0), measured("b", 1.5, 0)}),
              "a reaches rmse 0.1 first, after 10 s: 1.5 times sooner than b (15 s); likewise from 2 on");
    EXPECT_EQ(
        last_verdict({measured("a", 1, 0), measured("b", 1.5, 6)}),
        "too close to call at rmse 0.1: a (10 s) and b (15 s); b lost processor time to other processes and might "
        "have been first; likewise from 2 on");
    // That the first lost some makes it the more so.
    EXPECT_EQ(last_verdict({measured("a", 1, 6), measured("b", 1.5, 0)}),
              "a reaches rmse 0.1 first, after 10 s: 1.5 times sooner than b (15 s); a lost processor time to other "
              "processes, which changes nothing here; likewise from 2 on");
    // Less than the 5 s between them; where they are nearer it decides.
    const ComparisonTable table = make_table(Runs{measured("a", 1, 0), measured("b", 1.5, 2)}, {"rmse"});
    const std::vector<Verdict> found = verdicts(table);
    EXPECT_TRUE(found.front().close);
    EXPECT_FALSE(found.back().close);
    EXPECT_EQ(headlines(table, found).front().row, 0u);
}

TEST(DisturbedVerdict, ARowThatDidNotArriveMightHave) {
    // c ends at 32 s with 0.125: it never sees 0.1, but with 23 s less of clock it cannot be excluded.
    EXPECT_EQ(
        last_verdict({measured("a", 1, 0), measured("c", 4, 23)}),
        "too close to call at rmse 0.1: a (10 s); not in its time: c; c lost processor time to other processes and "
        "might have been first");
    EXPECT_EQ(
        last_verdict({measured("a", 1, 0), measured("c", 4, 3)}),
        "a reaches rmse 0.1 first, after 10 s; not in its time: c; c lost processor time to other processes, which "
        "changes nothing here; likewise from 0.2 on");
    // Ended by passes it is not there whatever its clock says.
    EXPECT_NE(last_verdict({measured("a", 1, 0), measured("c", 4, 23)}, {}).find("a reaches rmse 0.1 first"),
              std::string::npos);
}

}  // namespace
}  // namespace photond::repeats_test

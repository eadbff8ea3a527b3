// What comparisons say of their references and of their rows' films, from what the store holds of the jobs.

#include "server/service/row_films.h"

#include <gtest/gtest.h>

namespace photond::row_films_test {
namespace {

using nlohmann::json;

constexpr const char* kByTwo = R"({"reference": {"form": "two_films"}})";

/// Two jobs of one row, J3 and J4, that have been measured against the films J1 and J2.
Compared two_seeds(const std::string& metric = "relative_mse") {
    Compared compared;
    compared.row.seq = 1;
    compared.row.request = json{{"metrics", {metric}}, {"reference", json::object()}}.dump();
    const std::vector<int64_t> films{1, 2};
    for (const int64_t seq : films) {
        JobRow film;
        film.seq = seq;
        film.state = JobState::Succeeded;
        film.role = JobRole::Reference;
        film.film = "some.film";
        compared.references.push_back(film);
        compared.state.references.push_back({.seq = seq, .state = film.state});
    }
    for (const int64_t seq : {3, 4}) {
        JobRow job;
        job.seq = seq;
        job.state = JobState::Succeeded;
        job.method = "path_tracing";
        job.attempt = 1;
        job.film = "some.film";
        job.statistics = kByTwo;
        job.reference_jobs = films;
        compared.state.jobs.push_back({.seq = seq, .state = job.state, .reference_jobs = films});
        compared.jobs.emplace_back(ComparisonJob{seq, "a", "{}", static_cast<uint64_t>(seq - 2)}, job);
    }
    return compared;
}

void measured_against(Compared& compared, size_t job, const std::vector<int64_t>& references,
                      const std::string& statistics) {
    compared.jobs[job].second.reference_jobs = compared.state.jobs[job].reference_jobs = references;
    compared.jobs[job].second.statistics = statistics;
}

void remove_references(Compared& compared) {
    compared.references.clear();
    compared.state.references.clear();
}

RowFilms films_of_only_row(const Compared& compared) {
    return films_of_row(compared, judge(compared).table.rows.at(0));
}

std::string form(const Compared& compared) { return judge(compared).object.at("reference").at("form"); }

void keep_measurement(Compared& compared) {
    const json parts{{"squared_bias", 0.5},    {"low", 0.25}, {"high", 0.75}, {"variance", 1}, {"variance_low", json()},
                     {"variance_high", json()}};
    compared.biases.push_back(
        {films_of_only_row(compared).name, "beauty", json{{"mse", parts}, {"relative_mse", parts}}.dump()});
}

TEST(References, AreThoseOfAllJobsEachOnce) {
    const std::vector<JobProgress> jobs{{.seq = 5, .reference_jobs = {3, 4}},
                                        {.seq = 6},
                                        {.seq = 7, .reference_jobs = {3, 8}},
                                        {.seq = 9, .reference_jobs = {2}}};
    EXPECT_EQ(references_of(jobs), (std::vector<int64_t>{3, 4, 8, 2}));
    EXPECT_TRUE(references_of({}).empty());
}

TEST(References, AreTwoFilmsWhereAllFinishedJobsWereMeasuredSo) {
    Compared compared = two_seeds();
    EXPECT_EQ(form(compared), "two_films");
    remove_references(compared);
    EXPECT_EQ(form(compared), "two_films") << "how it was measured does not change with what is removed later";
    measured_against(compared, 0, {1}, R"({"reference": {"error": null}})");
    EXPECT_EQ(form(compared), "film") << "a job of before, beside one that was measured against two";
    measured_against(compared, 0, {1}, R"({"reference": null})");
    EXPECT_EQ(form(compared), "film");
    measured_against(compared, 0, {1, 2}, "");
    EXPECT_EQ(form(compared), "two_films") << "one is not finished";
    measured_against(compared, 1, {1, 2}, "");
    EXPECT_EQ(form(compared), "two_films") << "as they will be";
    measured_against(compared, 0, {1}, "");
    EXPECT_EQ(form(compared), "film");
}

TEST(RowFilms, AreMeasuredAgainstThePairOfTheirOwnJobs) {
    Compared compared = two_seeds();
    const RowFilms films = films_of_only_row(compared);
    EXPECT_TRUE(films.measurable());
    EXPECT_EQ(films.jobs, (std::vector<int64_t>{3, 4}));
    EXPECT_EQ(films.references, (std::vector<int64_t>{1, 2}));
    // Films of another row's reference change nothing.
    JobRow other = compared.references[0];
    other.seq = 7;
    compared.references.push_back(other);
    EXPECT_EQ(films_of_only_row(compared).name, films.name);
    measured_against(compared, 1, {1, 7}, kByTwo);
    EXPECT_EQ(films_of_only_row(compared).why_not, "its jobs have different references");
    measured_against(compared, 0, {1, 7}, kByTwo);
    EXPECT_TRUE(films_of_only_row(compared).measurable());
    EXPECT_NE(films_of_only_row(compared).name, films.name);
    for (const size_t job : {0, 1}) measured_against(compared, job, {1}, "{}");
    EXPECT_EQ(films_of_only_row(compared).why_not, "its reference is not two films");
}

TEST(RowFilms, WhatWasMeasuredOfThemIsShownWithoutTheReferencesFilms) {
    Compared compared = two_seeds();
    EXPECT_FALSE(judge(compared).table.rows[0].bias) << "nothing is measured yet";
    keep_measurement(compared);
    EXPECT_EQ(judge(compared).table.rows[0].bias->at("relative_mse").squared_bias, 0.5);
    remove_references(compared);
    EXPECT_FALSE(films_of_only_row(compared).measurable());
    EXPECT_EQ(judge(compared).object["table"][0]["bias"]["relative_mse"]["low"], 0.25);
    // Another attempt of a job is another film.
    compared.jobs[0].second.attempt = 2;
    EXPECT_FALSE(judge(compared).table.rows[0].bias);
}

TEST(RowFilms, AreMeasuredThoughNoMetricIsAMeanSquare) {
    Compared compared = two_seeds("flip_ldr");
    EXPECT_TRUE(judge(compared).object["table"][0]["bias"].is_null());
    keep_measurement(compared);
    EXPECT_EQ(judge(compared).object["table"][0]["bias"], json::object()) << "there is a map to be seen";
}

}  // namespace
}  // namespace photond::row_films_test

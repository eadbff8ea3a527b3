// Rows that have light which their reference lacks are marked, and who reads a verdict reads it.

#include "server/comparisons/left_out_marks.h"

#include <gtest/gtest.h>

#include "renderer/methods/registry.h"
#include "server/comparisons/headline.h"
#include "server/comparisons/verdict.h"
#include "server/left_out_json.h"

namespace photond::left_out_marks_test {
namespace {

using nlohmann::json;
using enum PathKind;

MeasuredJob job(const std::string& label, double seconds, const PathsLeftOut& left_out) {
    MeasuredJob job;
    job.id = job.label = label;
    job.parameters = json::object();
    job.state = "succeeded";
    for (uint32_t i = 0; i < 6; ++i)
        job.curve.push_back({seconds * (1 << i), 1u << i, {}, {{"relative_mse", 1.0 / (1 << i)}, {"direct:mse", 1.0}}});
    job.left_out = left_out;
    return job;
}

/// Rows that leave out all caustics of delta lights, only their first part, and nothing but further bounces.
ComparisonTable table(std::optional<PathsLeftOut> reference) {
    const std::vector<MeasuredJob> jobs{
        job("eye", 1, PathsLeftOut().add(DeltaLightCaustics).add(DeltaLightAfterCaustics)),
        job("lights", 10, PathsLeftOut().add(DeltaLightCaustics)),
        job("photons", 20, PathsLeftOut(2, {.diffuse = true}))};
    ComparisonTable table = make_table(jobs, {"relative_mse", "direct:mse"});
    table.reference_left_out = std::move(reference);
    return table;
}

TEST(LeftOutMarks, ARowIsMarkedForWhatTheReferenceLacksAndItHas) {
    const ComparisonTable found = table(PathsLeftOut().add(DeltaLightCaustics).add(DeltaLightAfterCaustics));
    EXPECT_EQ(mark_text(found, found.rows[0]), "");
    EXPECT_EQ(mark_text(found, found.rows[1]),
              "the reference lacks light of points, spots and suns that mirrors or smooth glass sent to a surface, "
              "scattered on from there: what this entry has of it counts as error");
    const std::string both = mark_text(found, found.rows[2]);
    EXPECT_TRUE(both.starts_with("the reference lacks light of points, spots and suns that mirrors")) << both;
    EXPECT_TRUE(both.ends_with("; so does what it lacks itself, light of more than 2 bounces")) << both;
    EXPECT_EQ(marked_rows(found, "relative_mse"), (std::vector<size_t>{1, 2}));
    EXPECT_EQ(marked_rows(found, "indirect:mse"), (std::vector<size_t>{1, 2}));
    EXPECT_TRUE(marked_rows(found, "direct:mse").empty()) << "bounced light is no part of it";

    const json rows = to_json(found);
    EXPECT_TRUE(rows[0].at("mark").is_null());
    EXPECT_EQ(rows[1].at("mark"), mark_text(found, found.rows[1]));
    EXPECT_EQ(rows[2].at("left_out"),
              json({{{"kind", "further_bounces"}, {"text", "light of more than 2 bounces"}, {"most_bounces", 2}}}));
}

TEST(LeftOutMarks, NobodyIsMarkedByAReferenceThatHasAll) {
    for (const auto& reference : {std::optional<PathsLeftOut>(PathsLeftOut()), std::optional<PathsLeftOut>()}) {
        const ComparisonTable found = table(reference);
        EXPECT_TRUE(marked_rows(found, "relative_mse").empty());
        for (const Verdict& verdict : verdicts(found))
            EXPECT_EQ(verdict_text(found, verdict).find("reference lacks"), std::string::npos);
    }
}

TEST(LeftOutMarks, VerdictsAndHeadlinesSayIt) {
    const ComparisonTable found = table(PathsLeftOut().add(DeltaLightCaustics).add(DeltaLightAfterCaustics));
    const std::vector<Verdict> all = verdicts(found);
    ASSERT_FALSE(all.empty());
    for (const Verdict& verdict : all) {
        const bool said = verdict_text(found, verdict)
                              .find(
                                  "; lights and photons have light that the reference lacks, "
                                  "which counts as their error") != std::string::npos;
        EXPECT_EQ(said, verdict.metric == "relative_mse") << verdict_text(found, verdict);
    }
    const std::vector<Headline> lines = headlines(found, all);
    ASSERT_FALSE(lines.empty());
    EXPECT_EQ(headline_text(found, lines[0]),
              "eye is better here, by a reference that lacks light which lights and photons have");
}

TEST(LeftOutMarks, WhatAJobLeftOutIsReadBackAndElseFollowsFromItsNeeds) {
    const PathsLeftOut left_out = PathsLeftOut(1, {.diffuse = true}).add(DeltaLightCaustics);
    const auto recorded = left_out_of_job({{"left_out", to_json(left_out)}}, nullptr);
    ASSERT_TRUE(recorded);
    EXPECT_EQ(recorded->kinds(), left_out.kinds());
    EXPECT_EQ(recorded->most_bounces(), 1u);
    EXPECT_EQ(left_out_of_job({{"left_out", to_json(PathsLeftOut(0, {.diffuse = true}))}}, nullptr)->kinds(),
              std::vector{FurtherBounces});

    const json before{{"needs", {{"delta", true}, {"punctual_lights", true}, {"diffuse", true}}}};
    const auto known = left_out_of_job(before, {{"name", "path_tracing"}, {"parameters", {{"indirect_bounces", 1}}}});
    ASSERT_TRUE(known);
    EXPECT_EQ(known->kinds(), (std::vector{FurtherBounces, DeltaLightCaustics}));
    EXPECT_FALSE(left_out_of_job(before, {{"name", "unheard_of"}}));
    EXPECT_FALSE(left_out_of_job({{"needs", nullptr}}, {{"name", "path_tracing"}}));
    EXPECT_FALSE(left_out_of_job(nullptr, {{"name", "path_tracing"}}));
}

}  // namespace
}  // namespace photond::left_out_marks_test

// The tables of a comparison as photonctl prints them.

#include "clients/cli/comparison_view.h"

#include <gtest/gtest.h>

#include <sstream>
#include <vector>

namespace photond::cli::comparison_view_test {
namespace {

using nlohmann::json;

/// A row of one level and one time: what its error, its time and its end are.
json row(const std::string& label, const json& time, const json& error, const json& end) {
    return {{"label", label},
            {"parameters", json::object()},
            {"passes", {{"min", 4}, {"max", 4}}},
            {"time_to_error", {{"mse", json::array({time})}}},
            {"error_at_time", {{"mse", json::array({error})}}},
            {"error", {{"mse", end}}}};
}

json mean(const char* name, double value, const json& low, const json& high, json more) {
    more[name] = value;
    more["low"] = low;
    more["high"] = high;
    return more;
}

std::string printed(const std::vector<json>& rows) {
    std::ostringstream out;
    print_comparison_tables(out, {{"request", {{"metrics", json::array({"mse"})}}}, {"table", rows}});
    return out.str();
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(ComparisonView, SaysWhatTheReferencesNoiseLeavesOpen) {
    json one = row("a", mean("seconds", 2, {}, {}, {{"error", 0.5}, {"earliest", 1.5}, {"latest", 2}}),
                   mean("error", 0.25, {}, {}, {{"seconds", 4}, {"interval", {0.2, 0.3}}}),
                   mean("value", 0.0012, {}, {}, {{"interval", {-0.002, 0.0044}}, {"near_reference", true}}));
    one["bias"] = {{"mse", {{"text", "its bias is known"}}}};
    std::string text = printed({one});
    EXPECT_TRUE(has(text, "2.00 s (1.50 s to 2.00 s)")) << text;
    EXPECT_TRUE(has(text, "0.25 (0.2 to 0.3)")) << text;
    EXPECT_TRUE(has(text, "0.0012 (-0.002 to 0.0044)!")) << text;
    EXPECT_TRUE(has(text, "mse is free of the references' noise")) << text;
    EXPECT_TRUE(has(text, "! not known to a third of itself, by the references' noise: a")) << text;
    EXPECT_TRUE(has(text, "a: its bias is known")) << text;
    one["time_to_error"]["mse"][0]["earliest"] = 1.9999;
    EXPECT_TRUE(has(printed({one}), "2.00 s\n")) << "of which the noise leaves nothing open";
    // Five rows have no space for intervals.
    text = printed({one, one, one, one, one});
    EXPECT_TRUE(has(text, "0.25")) << text;
    EXPECT_FALSE(has(text, "(")) << text;
}

TEST(ComparisonView, SeedsComeFirstAndBoundsAreMarked) {
    const json seeds = row("a", mean("seconds", 2, 1.8, 2.3, {{"error", 0.5}, {"earliest", 1.5}, {"latest", 2}}),
                           mean("error", -0.25, {}, {}, {{"seconds", 4}, {"interval", {-0.6, 0.125}}}),
                           mean("value", -0.5, -0.7, -0.3, {{"interval", {-0.75, -0.25}}, {"near_reference", true}}));
    const std::string text = printed({seeds});
    EXPECT_TRUE(has(text, "2.00 s (1.80 s to 2.30 s)")) << text;
    EXPECT_TRUE(has(text, "< 0.125")) << text;
    EXPECT_TRUE(has(text, "< 0.25!")) << "half of the width of what lies below 0\n" << text;
}

TEST(ComparisonView, OneFilmsNoiseIsStatedAsBefore) {
    const std::string text =
        printed({row("a", mean("seconds", 2, {}, {}, {{"error", 0.5}}), mean("error", 0.25, {}, {}, {{"seconds", 4}}),
                     mean("value", 0.1, {}, {}, {{"reference", 0.05}, {"near_reference", true}}))});
    EXPECT_TRUE(has(text, "0.1!")) << text;
    EXPECT_TRUE(has(text, "the reference's own noise: mse 0.05")) << text;
    EXPECT_TRUE(has(text, "! within three times that noise, which then is part of the figure: a")) << text;
}

}  // namespace
}  // namespace photond::cli::comparison_view_test

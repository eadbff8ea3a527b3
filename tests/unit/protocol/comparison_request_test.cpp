// What a comparison's body means: which jobs, in which order, and every fault at its place.

#include "protocol/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "protocol/error.h"

namespace photond::comparison_request_test {
namespace {

using nlohmann::json;

struct TinyParams final : MethodParams {
    uint32_t bounces = 8;
    uint32_t photons = 1000;
    float radius = 0.05f;
    void visit(ParamVisitor& visitor) override {
        using enum ParamGroup;
        visitor.field("bounces", bounces, {Light, "", 0, 1024, "bounces"});
        visitor.field("photons", photons, {Light, "", 1, 1e9, "photons"});
        visitor.field("radius", radius, {Light, "m", 1e-3, 10, "radius"});
    }
};

JobVocabulary vocabulary() {
    JobVocabulary known;
    known.method_names = {"path_tracing", "photon_mapping"};
    known.always_layers = {"emitted", "direct", "indirect"};
    known.layer_names = {"caustic", "albedo", "photon_count"};
    known.metric_names = {"relative_mse", "rmse", "flip_hdr", "estimated_relative_mse"};
    known.estimated_metrics = {"estimated_relative_mse"};
    known.radiance_layers = {"emitted", "direct", "indirect", "caustic"};
    known.make_params = [](const std::string&) { return std::make_unique<TinyParams>(); };
    known.devices_of = [](const std::string&) { return std::vector<std::string>{"cpu"}; };
    known.layers_of = [all = known.layer_names](const std::string& method) {
        return method == "path_tracing" ? std::vector<std::string>(all.begin(), all.end() - 1) : all;
    };
    return known;
}

json body() {
    return json::parse(R"({
        "scene": "cornell-box", "image": {"width": 64, "height": 32},
        "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 4096}},
        "entries": [
            {"label": "paths", "method": {"name": "path_tracing", "parameters": {"bounces": 3}}},
            {"method": {"name": "photon_mapping", "parameters": {"bounces": 3}},
             "sweep": {"radius": [0.2, 0.1], "photons": [5000, 25000, 125000]}}],
        "stop": {"seconds": 30}, "seeds": [3, 1]})");
}

using PointersAndDetails = std::vector<std::pair<std::string, std::string>>;

PointersAndDetails faults_of(const json& wrong) {
    try {
        parse_comparison_request(wrong, vocabulary());
    } catch (const Error& error) {
        PointersAndDetails found;
        for (const Fault& fault : error.faults) found.emplace_back(fault.pointer, fault.detail);
        std::sort(found.begin(), found.end());
        return found;
    }
    return {{"accepted", ""}};
}

std::vector<std::string> pointers_of(const json& wrong) {
    std::vector<std::string> pointers;
    for (const auto& [pointer, detail] : faults_of(wrong)) pointers.push_back(pointer);
    return pointers;
}

json with(const char* pointer, const char* value) {
    json changed = body();
    changed[json::json_pointer(pointer)] = json::parse(value);
    return changed;
}

using Pointers = std::vector<std::string>;

TEST(ComparisonRequest, PlansRowsInOrderAndSeedsBesideEachOther) {
    const ComparisonRequest request = parse_comparison_request(body(), vocabulary());
    std::vector<std::string> plan;
    for (const PlannedJob& job : request.jobs)
        plan.push_back(std::to_string(job.entry) + " " + job.label + " " + job.parameters.dump() + " " +
                       std::to_string(job.seed));
    // Parameters by name (photons, radius), the last one fastest; values as they were given.
    EXPECT_EQ(plan, (std::vector<std::string>{
                        "0 paths {} 3",
                        "0 paths {} 1",
                        R"(1 photon_mapping {"photons":5000,"radius":0.2} 3)",
                        R"(1 photon_mapping {"photons":5000,"radius":0.2} 1)",
                        R"(1 photon_mapping {"photons":5000,"radius":0.1} 3)",
                        R"(1 photon_mapping {"photons":5000,"radius":0.1} 1)",
                        R"(1 photon_mapping {"photons":25000,"radius":0.2} 3)",
                        R"(1 photon_mapping {"photons":25000,"radius":0.2} 1)",
                        R"(1 photon_mapping {"photons":25000,"radius":0.1} 3)",
                        R"(1 photon_mapping {"photons":25000,"radius":0.1} 1)",
                        R"(1 photon_mapping {"photons":125000,"radius":0.2} 3)",
                        R"(1 photon_mapping {"photons":125000,"radius":0.2} 1)",
                        R"(1 photon_mapping {"photons":125000,"radius":0.1} 3)",
                        R"(1 photon_mapping {"photons":125000,"radius":0.1} 1)",
                    }));
    const JobRequest& job = request.jobs[5].request;
    EXPECT_EQ(job.scene, "cornell-box");
    EXPECT_EQ(job.width, 64u);
    EXPECT_EQ(job.seed, 1u);
    EXPECT_EQ(job.stop.seconds, 30.0);
    EXPECT_EQ(job.reference->rendering->stop.passes, 4096u);
    EXPECT_EQ(job.method.parameters.dump(), R"({"bounces":3,"photons":5000,"radius":0.1})");
    EXPECT_EQ(job.metrics, (std::vector<std::string>{"relative_mse"}));
    EXPECT_EQ(request.metrics, (std::vector<std::string>{"relative_mse"}));
}

TEST(ComparisonRequest, TheEchoHasEveryDefaultAndIsAFixedPoint) {
    json rich = body();
    rich["metrics"] = {"indirect:relative_mse", "estimated_relative_mse", "flip_hdr"};
    rich["camera"] = {{"name", "camera"}};
    rich["layers"] = {"albedo"};
    rich["labels"] = {{"study", "x"}};
    rich["priority"] = 3;
    rich["glass"] = "solid";
    rich["environment"] = {{"image", "image:i"}, {"scale", 2}};
    for (const json& given : {body(), rich}) {
        const ComparisonRequest request = parse_comparison_request(given, vocabulary());
        const ComparisonRequest again = parse_comparison_request(json::parse(request.echo.dump()), vocabulary());
        EXPECT_EQ(request.echo.dump(), again.echo.dump());
        ASSERT_EQ(request.jobs.size(), again.jobs.size());
        for (size_t i = 0; i < request.jobs.size(); ++i) {
            EXPECT_EQ(to_json(request.jobs[i].request), to_json(again.jobs[i].request));
            EXPECT_EQ(request.jobs[i].parameters, again.jobs[i].parameters);
        }
    }
    json without_seeds = body();
    without_seeds.erase("seeds");
    EXPECT_EQ(parse_comparison_request(without_seeds, vocabulary()).echo.at("seeds"), json::parse("[1]"));
    const json echo = parse_comparison_request(body(), vocabulary()).echo;
    EXPECT_EQ(echo.at("seeds"), json::parse("[3, 1]"));
    EXPECT_EQ(echo.at("priority"), 0);
    EXPECT_EQ(echo.at("entries")[1].at("label"), "photon_mapping");
    EXPECT_EQ(echo.at("entries")[1].at("method").at("parameters"), json::parse(R"({"bounces": 3})"));
    EXPECT_EQ(echo.at("entries")[0].at("method").at("parameters").at("photons"), 1000);
}

TEST(ComparisonRequest, JobsMeasureWhatTheTablesNeed) {
    json given = body();
    given["metrics"] = {"indirect:relative_mse", "estimated_relative_mse", "flip_hdr"};
    const ComparisonRequest request = parse_comparison_request(given, vocabulary());
    // Not what is estimated anyway; and the rmse that the efficiency is of.
    EXPECT_EQ(request.jobs[0].request.metrics,
              (std::vector<std::string>{"indirect:relative_mse", "flip_hdr", "indirect:rmse"}));
}

TEST(ComparisonRequest, OnlyEstimatedMetricsNeedNoReference) {
    json given = body();
    given.erase("reference");
    EXPECT_EQ(pointers_of(given), Pointers{"/reference"});
    given["metrics"] = {"estimated_relative_mse"};
    EXPECT_EQ(pointers_of(given), Pointers{"accepted"});
    given["metrics"] = {"estimated_relative_mse", "rmse"};
    EXPECT_EQ(pointers_of(given), Pointers{"/reference"});
}

TEST(ComparisonRequest, EachFaultIsNamedOnceAtItsPlace) {
    EXPECT_EQ(pointers_of(json(5)), Pointers{""});
    EXPECT_EQ(pointers_of(with("/scene", "5")), Pointers{"/scene"});
    EXPECT_EQ(pointers_of(with("/image/width", "0")), Pointers{"/image/width"});
    EXPECT_EQ(pointers_of(with("/reference/stop/passes", "0")), Pointers{"/reference/stop/passes"});
    EXPECT_EQ(pointers_of(with("/entries/0/method/name", "\"path_tracin\"")), Pointers{"/entries/0/method/name"});
    EXPECT_EQ(pointers_of(with("/entries/0/method/parameters/bounces", "-1")),
              Pointers{"/entries/0/method/parameters/bounces"});
    EXPECT_EQ(pointers_of(with("/entries/1/method/parameters", "7")), Pointers{"/entries/1/method/parameters"});
    EXPECT_EQ(pointers_of(with("/entries/1/method/device", "\"gpu\"")), Pointers{"/entries/1/method/device"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/photons/1", "0")), Pointers{"/entries/1/sweep/photons/1"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/photons/2", "null")), Pointers{"/entries/1/sweep/photons/2"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/photons", "[]")), Pointers{"/entries/1/sweep/photons"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/photons", "5")), Pointers{"/entries/1/sweep/photons"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/photons/2", "5000.0")), Pointers{"/entries/1/sweep/photons/2"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/radius/1", "0.2000000000001")), Pointers{"/entries/1/sweep"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/photns", "[1, 2, 3]")), Pointers{"/entries/1/sweep/photns"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep/bounces", "[1]")), Pointers{"/entries/1/sweep/bounces"});
    EXPECT_EQ(pointers_of(with("/entries/1/sweep", "[1]")), Pointers{"/entries/1/sweep"});
    EXPECT_EQ(pointers_of(with("/entries/1/lable", "\"x\"")), Pointers{"/entries/1/lable"});
    EXPECT_EQ(pointers_of(with("/entries/1/label", "\"paths\"")), Pointers{"/entries/1/label"});
    EXPECT_EQ(pointers_of(with("/entries/1", "3")), Pointers{"/entries/1"});
    EXPECT_EQ(pointers_of(with("/entries", "[]")), Pointers{"/entries"});
    EXPECT_EQ(pointers_of(with("/seeds/1", "-1")), Pointers{"/seeds/1"});
    EXPECT_EQ(pointers_of(with("/seeds/1", "3")), Pointers{"/seeds/1"});
    EXPECT_EQ(pointers_of(with("/seeds/1", "null")), Pointers{"/seeds/1"});
    EXPECT_EQ(pointers_of(with("/seeds", "[]")), Pointers{"/seeds"});
    EXPECT_EQ(pointers_of(with("/metrics", "[\"relative_mse\", \"rmes\"]")), Pointers{"/metrics/1"});
    EXPECT_EQ(pointers_of(with("/metrics", "[\"rmse\", \"rmse\"]")), Pointers{"/metrics/1"});
    EXPECT_EQ(pointers_of(with("/metrics", "[\"rmse\", \"caustic:rmse\"]")), Pointers{"/metrics/1"});
    EXPECT_EQ(pointers_of(with("/metrics", "[7]")), Pointers{"/metrics/0"});
    EXPECT_EQ(pointers_of(with("/layers", "[\"photon_count\"]")), Pointers{"/layers/0"});
    EXPECT_EQ(pointers_of(with("/stop", "{\"target\": {\"metric\": \"rmes\", \"value\": 1}}")),
              Pointers{"/stop/target/metric"});
    EXPECT_EQ(pointers_of(with("/method", "{}")), Pointers{"/method"});
}

TEST(ComparisonRequest, AllFaultsAreNamedTogether) {
    json wrong = body();
    wrong["scene"] = 5;
    wrong["image"]["width"] = 0;
    wrong["entries"][0]["method"]["name"] = "nothing";
    wrong["entries"][1]["sweep"]["photons"] = {0, 5000, -1};
    wrong["seeds"] = json::parse(R"([1, 2, "x"])");
    wrong["metrics"] = {"rmse", "no"};
    wrong["sceen"] = 1;
    EXPECT_EQ(pointers_of(wrong),
              (Pointers{"/entries/0/method/name", "/entries/1/sweep/photons/0", "/entries/1/sweep/photons/2",
                        "/image/width", "/metrics/1", "/sceen", "/scene", "/seeds/2"}));
    // Also where no entry can be read.
    wrong["entries"] = json::parse(R"([{"label": "x"}])");
    EXPECT_EQ(pointers_of(wrong), (Pointers{"/entries/0/method", "/image/width", "/metrics/1", "/sceen", "/scene"}));
}

TEST(ComparisonRequest, HasAtMostAThousandJobs) {
    json many = body();
    json values = json::array();
    for (int i = 1; i <= 166; ++i) values.push_back(i);
    many["entries"][1]["sweep"] = {{"photons", values}, {"radius", {0.1, 0.2, 0.3}}};
    many["seeds"] = json::parse("[1, 2]");
    EXPECT_EQ(parse_comparison_request(many, vocabulary()).jobs.size(), 998u);
    many["entries"][1]["sweep"]["photons"].push_back(167);
    EXPECT_EQ(pointers_of(many), Pointers{"/entries"});
    // Products beyond 64 bits are too many as well.
    json huge = json::array();
    for (int i = 0; i < 1000; ++i) huge.push_back(i + 1);
    many["entries"][1]["sweep"] = {{"photons", huge}, {"bounces", huge}, {"radius", huge}};
    many["entries"][1]["method"].erase("parameters");
    EXPECT_EQ(pointers_of(many), Pointers{"/entries"});
}

}  // namespace
}  // namespace photond::comparison_request_test

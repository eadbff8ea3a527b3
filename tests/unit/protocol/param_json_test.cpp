#include "protocol/param_json.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace photond::param_json_test {
namespace {

enum class Kind : uint8_t { First, Second };
constexpr std::array<std::string_view, 2> kKinds{"first", "second"};

struct SampleParams final : MethodParams {
    float radius = 0.1f;
    uint32_t photons = 1000;
    std::optional<float> clamp;
    std::optional<uint32_t> bounces = 5;
    bool fast = true;
    Kind kind = Kind::Second;

    void visit(ParamVisitor& visitor) override {
        using enum ParamGroup;
        visitor.field("radius", radius, {Light, "m", 1e-6, 1e3, "gather radius"});
        visitor.field("photons", photons, {Light, "photons", 1, 1e9, "photons a pass"});
        visitor.field("clamp", clamp, {Light, "", 0, 3e38, "limit"});
        visitor.field("bounces", bounces, {Light, "", 0, 64, "bounces"});
        visitor.flag("fast", fast, {Filter, "be fast"});
        visitor.enumeration("kind", kind, {Light, kKinds, "which"});
    }
    void check() const override {
        if (clamp && bounces && *bounces == 0) throw Error(ErrorCode::Conflict, "/clamp", "clamp needs bounces");
    }
};

std::vector<Fault> faults_of(const char* text) {
    SampleParams params;
    std::vector<Fault> faults;
    read_params(params, nlohmann::json::parse(text), "/p", faults);
    return faults;
}

TEST(ParamJson, KeepsDefaultsAndEchoesThem) {
    SampleParams params;
    std::vector<Fault> faults;
    read_params(params, nlohmann::json::object(), "", faults);
    EXPECT_TRUE(faults.empty());
    EXPECT_EQ(params_to_json(params).dump(),
              R"({"bounces":5,"clamp":null,"fast":true,"kind":"second","photons":1000,"radius":0.1})");
}

TEST(ParamJson, TheEchoReadsBackBitByBit) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> exponent(-5.9f, 2.9f);
    for (int i = 0; i < 2000; ++i) {
        SampleParams params, again;
        params.radius = std::pow(10.0f, exponent(random));
        params.clamp = std::pow(10.0f, 10 * exponent(random));
        if (!(*params.clamp < 3e38f)) params.clamp.reset();
        params.photons = static_cast<uint32_t>(random() % 1'000'000'000 + 1);
        if (i % 2 == 0) params.bounces.reset();
        std::vector<Fault> faults;
        read_params(again, nlohmann::json::parse(params_to_json(params).dump()), "", faults);
        ASSERT_TRUE(faults.empty()) << faults[0].detail;
        ASSERT_EQ(params.radius, again.radius);
        ASSERT_EQ(params.clamp, again.clamp);
        ASSERT_EQ(params.photons, again.photons);
        ASSERT_EQ(params.bounces, again.bounces);
    }
}

TEST(ParamJson, NamesEveryFaultAtOnce) {
    const std::vector<Fault> faults = faults_of(
        R"({"radius": "big", "photons": 0, "clamp": -1, "bounces": 1.5, "fast": 1, "kind": "secnd", "radios": 1})");
    std::vector<std::string> pointers;
    for (const Fault& fault : faults) pointers.push_back(fault.pointer);
    EXPECT_EQ(pointers, (std::vector<std::string>{"/p/radius", "/p/photons", "/p/clamp", "/p/bounces", "/p/fast",
                                                  "/p/kind", "/p/radios"}));
    EXPECT_EQ(faults[1].detail, "photons: 0 is outside [1, 1e+09] photons");
    EXPECT_NE(faults[5].detail.find("did you mean \"second\""), std::string::npos);
    EXPECT_NE(faults[6].detail.find("did you mean \"radius\""), std::string::npos);
}

TEST(ParamJson, HoldsRangesAndWholeness) {
    EXPECT_TRUE(faults_of(R"({"photons": 5.0, "bounces": null, "clamp": 0, "radius": 1000})").empty());
    for (const char* text :
         {R"({"radius": 1000.1})", R"({"radius": 0})", R"({"radius": 1e300})", R"({"radius": null})",
          R"({"photons": -1})", R"({"photons": 1e10})", R"({"photons": 0.5})", R"({"photons": true})",
          R"({"photons": 18446744073709551615})", R"({"kind": 0})", R"({"fast": null})", "[]", "null"})
        EXPECT_EQ(faults_of(text).size(), 1u) << text;
}

TEST(ParamJson, AsksTheParametersThemselvesLast) {
    const std::vector<Fault> faults = faults_of(R"({"clamp": 1, "bounces": 0})");
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_EQ(faults[0].pointer, "/p/clamp");
}

TEST(ParamJson, SchemaSaysWhatTheReaderHolds) {
    SampleParams params;
    const nlohmann::json schema = params_schema(params);
    EXPECT_EQ(schema["additionalProperties"], false);
    const nlohmann::json& properties = schema["properties"];
    EXPECT_EQ(properties["radius"]["type"], "number");
    EXPECT_EQ(properties["radius"]["default"].dump(), "0.1");
    EXPECT_EQ(properties["radius"]["x-unit"], "m");
    EXPECT_EQ(properties["photons"]["type"], "integer");
    EXPECT_EQ(properties["photons"]["maximum"].dump(), "1000000000");
    EXPECT_EQ(properties["clamp"]["type"].dump(), R"(["number","null"])");
    EXPECT_EQ(properties["kind"]["enum"].dump(), R"(["first","second"])");
    EXPECT_EQ(properties["kind"]["default"], "second");
    EXPECT_EQ(schema["x-order"].size(), 6u);
    EXPECT_EQ(schema["x-groups"].dump(), R"(["Light","Filter"])");
    EXPECT_EQ(properties["fast"]["x-group"], "Filter");
}

TEST(ParamJson, ShortestDouble) {
    EXPECT_EQ(shortest_double(0.1f), 0.1);
    EXPECT_EQ(shortest_double(16777216.0f), 16777216.0);
    EXPECT_EQ(static_cast<float>(shortest_double(1.17549435e-38f)), 1.17549435e-38f);
}

}  // namespace
}  // namespace photond::param_json_test
